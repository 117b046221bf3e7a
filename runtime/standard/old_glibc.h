/* Functions of the mathematical library as every glibc for x86-64 has them: newer ones differ in how errno is set alone. What is
 * built with this loads on systems that are older than the one it was built on. */
#ifndef LAG_OLD_GLIBC_H
#define LAG_OLD_GLIBC_H

#if defined(__x86_64__)
__asm__(".symver exp,exp@GLIBC_2.2.5");
__asm__(".symver exp2,exp2@GLIBC_2.2.5");
__asm__(".symver log,log@GLIBC_2.2.5");
__asm__(".symver log2,log2@GLIBC_2.2.5");
__asm__(".symver pow,pow@GLIBC_2.2.5");
__asm__(".symver hypot,hypot@GLIBC_2.2.5");
__asm__(".symver fmod,fmod@GLIBC_2.2.5");
#endif

#endif
