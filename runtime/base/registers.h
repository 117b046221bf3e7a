/* Wide registers are left clean for code that knows narrow ones alone.
 *
 * GCC 12 does not clear their upper halves before it calls a function of the same file that touches none, and takes them for clean
 * behind it. Instructions of the old kind (libm's fmin, what is compiled for any processor) wait for them from then on, 30 ns at each
 * change between the kinds, until something clears them: a third of the time of runs with many events.
 */
#ifndef LAG_REGISTERS_H
#define LAG_REGISTERS_H

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-ipa-ra")
#endif

#endif
