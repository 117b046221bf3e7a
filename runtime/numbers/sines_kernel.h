/* The function LAG_SINES: sines and cosines of as many angles, of up to LAG_LARGEST_ANGLE, as LAG_SINES_NUMBERS holds. Included once for
 * each width (sines.h, wide.h). */
static inline void LAG_SINES(const LAG_SINES_NUMBERS *angle, LAG_SINES_NUMBERS *sine, LAG_SINES_NUMBERS *cosine)
{
    typedef LAG_SINES_NUMBERS Numbers;
    typedef LAG_SINES_WORDS Words;
    const double rounding = 6755399441055744.0; /* 1.5 * 2^52: a sum with it is a whole number, in the lowest bits */
    const Numbers shifted = *angle * 0.6366197723675814 + rounding, turns = shifted - rounding;
    const Numbers first = *angle - turns * 1.5707963267341256, second = turns * 6.077100506303966e-11;
    const Numbers rest = first - second;
    const Numbers third = turns * 2.0222662487959506e-21 - ((first - rest) - second);
    const Numbers r = rest - third, tail = (rest - r) - third;
    const Numbers z = r * r, z2 = z * z, z4 = z2 * z2, half = z * 0.5, near = 1.0 - half;
    const Numbers p = (z * 0.008333333333330948 - 0.16666666666666666)
                      + z2 * (z * 2.7557316101617874e-06 - 0.00019841269836756774)
                      + z4 * (z * 1.5918115263265974e-10 - 2.505113165023518e-08);
    const Numbers q = (z * -0.0013888888888887398 + 0.041666666666666664)
                      + z2 * (z * -2.7557317271145144e-07 + 2.480158729876456e-05)
                      + z4 * (z * -1.1382623647474604e-11 + 2.087614614655861e-09);
    const Numbers s = r + (r * z * p + tail * near), c = near + (((1.0 - near) - half) + (z2 * q - r * tail));
    /* After an odd number of quarter turns they change places; after two the sine changes its sign, and after one the cosine. */
    const Words count = LAG_SINES_WORDS_OF(shifted), s_words = LAG_SINES_WORDS_OF(s), c_words = LAG_SINES_WORDS_OF(c);
    const Words swap = (s_words ^ c_words) & -(count & 1), sign = (count << 62) & LAG_LANES_SIGN;
    *sine = LAG_SINES_OF_WORDS(s_words ^ swap ^ sign);
    *cosine = LAG_SINES_OF_WORDS(c_words ^ swap ^ sign ^ (count << 63));
}

#undef LAG_SINES
#undef LAG_SINES_NUMBERS
#undef LAG_SINES_WORDS
#undef LAG_SINES_WORDS_OF
#undef LAG_SINES_OF_WORDS
