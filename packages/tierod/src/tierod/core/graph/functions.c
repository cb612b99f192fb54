/* The mathematical functions of every kernel, in parts; c_functions.py picks those that are needed, and puts constants
   and polynomials of the precision in place of what stands between @. */

/*** bits ***/
typedef @WORD@ tierod_word;
#define TIEROD_WHOLE @WHOLE@ /* a sum with it holds a whole number in its lowest bits */
#define TIEROD_SIGN ((tierod_word)1 << @SIGN_BIT@)
TIEROD_INLINE tierod_word tierod_bits(real x) { tierod_word b; memcpy(&b, &x, sizeof b); return b; }
TIEROD_INLINE real tierod_number(tierod_word b) { real x; memcpy(&x, &b, sizeof x); return x; }
/* 2^k of a whole number whose power is a normal number. */
TIEROD_INLINE real tierod_power_of_two(real k) {
    return tierod_number((tierod_bits(k + TIEROD_WHOLE) + @BIAS_COUNT@) << @FRACTION@);
}
/* The size of a with the sign of b. */
TIEROD_INLINE real tierod_signed(real a, real b) {
    return tierod_number((tierod_bits(a) & ~TIEROD_SIGN) | (tierod_bits(b) & TIEROD_SIGN));
}

/*** exact ***/
/* What the sum s = a + b lost (Knuth). */
TIEROD_INLINE real tierod_sum_error(real a, real b, real s) {
    const real t = s - a;
    return (a - (s - t)) + (b - t);
}
/* What the product p = a * b lost (Dekker, where there is no fused operation). */
TIEROD_INLINE real tierod_product_error(real a, real b, real p) {
#ifdef TIEROD_FAST_FMA
    return M(fma)(a, b, -p);
#else
    const real c = @SPLITTER@ * a, d = @SPLITTER@ * b;
    const real ah = c - (c - a), bh = d - (d - b), al = a - ah, bl = b - bh;
    return ((ah * bh - p) + ah * bl + al * bh) + al * bl;
#endif
}

/*** far double ***/
/* 2/pi times 2^(16 i), less whole turns, in four parts. */
static const real tierod_turns[] = {
    @TURNS@
};
TIEROD_INLINE tierod_word tierod_far_reduced(real x, real *rest, real *tail) {
    const tierod_word size = tierod_bits(x) & ~TIEROD_SIGN;
    const tierod_word above = (size >> 52) - 1043, row = above > 1003 ? 0 : above / 16;
    const real m = tierod_number(size - (row * 16 << 52));
    const real *t = &tierod_turns[row * 4];
    const real p0 = m * t[0], p1 = m * t[1], p2 = m * t[2];
    const real q0 = tierod_product_error(m, t[0], p0), q1 = tierod_product_error(m, t[1], p1);
    const real q2 = tierod_product_error(m, t[2], p2);
    const real huge = 7083549724304467820544.0, four = 27021597764222976.0; /* 1.5 * 2^72, 1.5 * 2^54 */
    const real f = p0 - ((p0 + huge) - huge), f0 = f - ((f + four) - four), f1 = q0 - ((q0 + four) - four);
    const real f2 = p1 - ((p1 + four) - four);
    const real s1 = f0 + f1, s2 = s1 + f2, shifted = s2 + TIEROD_WHOLE, a = s2 - (shifted - TIEROD_WHOLE);
    const real l = tierod_sum_error(f0, f1, s1) + tierod_sum_error(s1, f2, s2);
    const real b1 = q1 + p2, b2 = l + b1, h = a + b2;
    const real low = tierod_sum_error(a, b2, h) + (tierod_sum_error(q1, p2, b1) + tierod_sum_error(l, b1, b2)
        + (q2 + m * t[3]));
    const real r = h * 1.5707963267948966;
    const real e = tierod_product_error(h, 1.5707963267948966, r)
        + (h * 6.123233995736766e-17 + low * 1.5707963267948966);
    *rest = x < 0.0 ? -r : r;
    *tail = x < 0.0 ? -e : e;
    return x < 0.0 ? 0 - tierod_bits(shifted) : tierod_bits(shifted);
}

/*** far float ***/
/* 32 zeros, and the first 224 digits of 2/pi. */
static const uint32_t tierod_turns[] = { @TURNS@ };
TIEROD_INLINE tierod_word tierod_far_reduced(real x, real *rest, real *tail) {
    const uint32_t size = tierod_bits(x) & ~TIEROD_SIGN, e = size >> 23, far = e < 120 || e > 254 ? 0 : e - 120;
    const uint64_t m = (size & 0x7fffff) | 0x800000;
    const uint32_t *t = &tierod_turns[far / 32], down = 32 - far % 32;
    const uint32_t a0 = (uint32_t)((((uint64_t)t[0] << 32) | t[1]) >> down);
    const uint32_t a1 = (uint32_t)((((uint64_t)t[1] << 32) | t[2]) >> down);
    const uint32_t a2 = (uint32_t)((((uint64_t)t[2] << 32) | t[3]) >> down);
    const uint64_t part = ((m * a0) << 32) + m * a1 + ((m * a2) >> 32); /* of a turn, times 2^64 */
    const uint64_t turns = (part + ((uint64_t)1 << 61)) >> 62;
    const int64_t left = (int64_t)(part - (turns << 62));
    const real h = (real)left, low = (real)(left - (int64_t)h);
    const real r = h * @EIGHTH@;
    const real e_r = tierod_product_error(h, @EIGHTH@, r)
        + (h * @EIGHTH_LOW@ + low * @EIGHTH@);
    const real nothing = x - x; /* NaN of an infinite angle */
    *rest = (x < 0.0f ? -r : r) + nothing;
    *tail = x < 0.0f ? -e_r : e_r;
    return (tierod_word)(x < 0.0f ? 0 - turns : turns);
}

/*** reduction ***/
/* x less the nearest whole number of quarter turns, as rest + tail; the lowest two bits count the quarter turns. */
TIEROD_INLINE tierod_word tierod_reduced(real x, real *rest, real *tail) {
    const real shifted = tierod_fma(x, @TWO_OVER_PI@, TIEROD_WHOLE), k = shifted - TIEROD_WHOLE;
    const real r1 = x - k * @QUARTER_1@, w2 = -(k * @QUARTER_2@), w3 = -(k * @QUARTER_3@);
    const real r2 = r1 + w2, r3 = r2 + w3;
    const real e = tierod_sum_error(r1, w2, r2) + tierod_sum_error(r2, w3, r3);
    tierod_word turns = tierod_bits(shifted);
    *rest = r3;
    *tail = e - k * @QUARTER_4@;
    if (!(M(fabs)(x) <= @LARGEST_ANGLE@))
        turns = tierod_far_reduced(x, rest, tail);
    return turns;
}

/*** circular ***/
/* Of x + y within an eighth of a turn, the y small beside x; lost: what the result lacks. */
TIEROD_INLINE real tierod_sine_near(real x, real y, real *lost) {
    const real z = x * x;
@POLYNOMIAL p z SINE@
    const real less = tierod_fma(-(x * z), p, R(0.5) * z * y - y), v = x - less;
    *lost = (x - v) - less;
    return v;
}
TIEROD_INLINE real tierod_cosine_near(real x, real y, real *lost) {
    const real z = x * x, half = R(0.5) * z, w = R(1.0) - half;
@POLYNOMIAL p z COSINE@
    const real more = ((R(1.0) - w) - half) + tierod_fma(z * z, p, -x * y), v = w + more;
    *lost = (w - v) + more;
    return v;
}
TIEROD_INLINE real tierod_sin(real x) {
    real rest, tail, lost;
    const tierod_word turns = tierod_reduced(x, &rest, &tail);
    const real s = tierod_sine_near(rest, tail, &lost), c = tierod_cosine_near(rest, tail, &lost);
    const real v = turns & 1 ? c : s;
    return turns & 2 ? -v : v;
}
TIEROD_INLINE real tierod_cos(real x) {
    real rest, tail, lost;
    const tierod_word turns = tierod_reduced(x, &rest, &tail);
    const real s = tierod_sine_near(rest, tail, &lost), c = tierod_cosine_near(rest, tail, &lost);
    const real v = turns & 1 ? s : c;
    return (turns + 1) & 2 ? -v : v;
}
TIEROD_INLINE real tierod_tan(real x) {
    real rest, tail, s_low, c_low;
    const tierod_word turns = tierod_reduced(x, &rest, &tail);
    const real s = tierod_sine_near(rest, tail, &s_low), c = tierod_cosine_near(rest, tail, &c_low);
    const real a = turns & 1 ? c : s, b = turns & 1 ? s : c, v = a / b, back = v * b;
    const real a_low = turns & 1 ? c_low : s_low, b_low = turns & 1 ? s_low : c_low;
    const real w = v - (((back - a) + tierod_product_error(v, b, back) - a_low) + v * b_low) / b;
    return turns & 1 ? -w : w;
}

/*** arctangent ***/
TIEROD_INLINE real tierod_atan2(real y, real x) {
    const real infinite = (real)INFINITY, ay = M(fabs)(y), ax = M(fabs)(x);
    const real least = ay < ax ? ay : ax, most = ay < ax ? ax : ay;
    const real scale = most > @ANGLE_LARGE@ ? @ANGLE_DOWN@ : most < @ANGLE_SMALL@ ? @ANGLE_UP@ : R(1.0);
    const int diagonal = (ax == infinite) & (ay == infinite);
    const real n = diagonal ? R(1.0) : least * scale;
    const real d = (diagonal | (most == R(0.0))) ? R(1.0) : most * scale;
    /* The angle from that of 0, 1/2 or 1, whichever lies near. */
    const int near_one = n > R(0.68) * d, near_half = n > R(0.4) * d;
    const real up_by = near_one ? n - d : near_half ? R(2.0) * n - d : n;
    const real t = up_by / (near_one ? n + d : near_half ? R(2.0) * d + n : d), z = t * t;
    const real a = near_one ? @PI_4@ : near_half ? @ATAN_HALF@ : R(0.0);
    const real a_low = near_one ? @PI_4_LOW@ : near_half ? @ATAN_HALF_LOW@ : R(0.0);
@POLYNOMIAL p z ARCTANGENT@
    const real small = tierod_fma(t * z, p, t);
    /* Into the quadrant: b + s * angle. */
    const int steep = ay > ax, back = (tierod_bits(x) & TIEROD_SIGN) != 0;
    const real b = steep ? @PI_2@ : back ? @PI@ : R(0.0);
    const real b_low = steep ? @PI_2_LOW@ : back ? @PI_LOW@ : R(0.0);
    const real s = steep != back ? -R(1.0) : R(1.0), whole = b + s * a;
    const real low = tierod_sum_error(b, s * a, whole) + tierod_fma(s, a_low, b_low);
    return tierod_signed(whole + (low + s * small), y);
}
TIEROD_INLINE real tierod_atan(real x) { return tierod_atan2(x, R(1.0)); }
TIEROD_INLINE real tierod_asin(real x) {
    const real square = M(fabs)(x) < R(0.5) ? tierod_fma(-x, x, R(1.0)) : (R(1.0) - x) * (R(1.0) + x);
    return tierod_atan2(x, M(sqrt)(square));
}
TIEROD_INLINE real tierod_acos(real x) { return R(2.0) * tierod_atan(M(sqrt)((R(1.0) - x) / (R(1.0) + x))); }

/*** exponential ***/
/* exp(x + tail) / 2^halvings, the tail small beside x. */
TIEROD_INLINE real tierod_scaled_exp(real x, real tail, real halvings) {
    const real y = x > @HIGHEST@ + R(1.0) ? @HIGHEST@ + R(1.0) : x < @LOWEST@ ? @LOWEST@ : x;
    const real k = tierod_fma(y, R(1.4426950408889634), TIEROD_WHOLE) - TIEROD_WHOLE;
    const real r = tierod_fma(-k, @LN2_LOW@, tierod_fma(-k, @LN2@, y)) + tail;
@POLYNOMIAL p r EXPONENTIAL@
    const real e = R(1.0) + tierod_fma(r * r, p, r);
    /* In two steps: where the result is subnormal or near the largest, its power of two alone is no number. */
    const real half = tierod_fma(k, R(0.5), TIEROD_WHOLE) - TIEROD_WHOLE;
    const real v = e * tierod_power_of_two(half) * tierod_power_of_two(k - half - halvings);
    return x > @HIGHEST@ + R(0.6931471805599453) * halvings ? (real)INFINITY : x < @LOWEST@ ? R(0.0) : v;
}
TIEROD_INLINE real tierod_exp(real x) { return tierod_scaled_exp(x, R(0.0), R(0.0)); }
TIEROD_INLINE real tierod_expm1(real x) {
    const real y = x > @HIGHEST@ + R(1.0) ? @HIGHEST@ + R(1.0) : x < R(-50.0) ? R(-50.0) : x;
    const real k = tierod_fma(y, R(1.4426950408889634), TIEROD_WHOLE) - TIEROD_WHOLE;
    const real far = tierod_fma(-k, @LN2@, y), r = tierod_fma(-k, @LN2_LOW@, far);
    const real tail = tierod_fma(-k, @LN2_LOW@, far - r);
@POLYNOMIAL p r EXPONENTIAL@
    const real half = tierod_fma(k, R(0.5), TIEROD_WHOLE) - TIEROD_WHOLE;
    /* 2^k (1 - 2^-k + exp(r) - 1) */
    const real less = k > @MOST_HALVINGS@ ? R(0.0) : tierod_power_of_two(-half) * tierod_power_of_two(half - k);
    const real c = R(1.0) - less, t = c + r;
    const real e = t + (tierod_sum_error(c, r, t) + tierod_fma(r * r, p, tail));
    const real v = e * tierod_power_of_two(half) * tierod_power_of_two(k - half);
    return x > @HIGHEST@ ? (real)INFINITY : x == R(0.0) ? x : v;
}
TIEROD_INLINE real tierod_tanh(real x) {
    const real a = M(fabs)(x), z = x * x, e = tierod_exp(R(2.0) * a);
@POLYNOMIAL n z TANH_ABOVE@
@POLYNOMIAL d z TANH_BELOW@
    const real q = (a < R(0.625) ? z * n : R(2.0)) / (a < R(0.625) ? d : e + R(1.0));
    return tierod_signed(a < R(0.625) ? tierod_fma(a, q, a) : R(1.0) - q, x);
}
TIEROD_INLINE real tierod_sinh(real x) {
    const real a = M(fabs)(x), z = x * x, h = tierod_scaled_exp(a, R(0.0), R(1.0));
@POLYNOMIAL p z SINH@
    return a < R(1.0) ? tierod_fma(x * z, p, x) : tierod_signed(h - R(0.25) / h, x);
}
TIEROD_INLINE real tierod_cosh(real x) {
    const real h = tierod_scaled_exp(M(fabs)(x), R(0.0), R(1.0));
    return h + R(0.25) / h;
}

/*** logarithm ***/
/* x = 2^k m with m in [sqrt(1/2), sqrt(2)). */
TIEROD_INLINE real tierod_split(real x, real *m) {
    const int subnormal = x < @LEAST@;
    const tierod_word b = tierod_bits(subnormal ? x * @SUBNORMAL_UP@ : x);
    const tierod_word e = (b + (tierod_bits(R(1.0)) - tierod_bits(@SQRT_HALF@))) >> @FRACTION@;
    *m = tierod_number(b - (e << @FRACTION@) + tierod_bits(R(1.0)));
    return tierod_number(tierod_bits(TIEROD_WHOLE) + e) - TIEROD_WHOLE
        - (subnormal ? @SUBNORMAL_BIAS@ : @BIAS@);
}
TIEROD_INLINE real tierod_log_of_value(real x, real v) {
    const real infinite = (real)INFINITY;
    return x > R(0.0) ? (x < infinite ? v : x) : x == R(0.0) ? -infinite : (real)NAN;
}
/* log(2^k (1 + f)), f with an error c. */
TIEROD_INLINE real tierod_log_of_parts(real k, real f, real c) {
    const real s = f / (R(2.0) + f), z = s * s, half = R(0.5) * f * f;
@POLYNOMIAL p z LOGARITHM@
    return k * @LN2@ - ((half - (s * (half + z * p) + (k * @LN2_LOW@ + c))) - f);
}
TIEROD_INLINE real tierod_log(real x) {
    real m;
    const real k = tierod_split(x, &m);
    return tierod_log_of_value(x, tierod_log_of_parts(k, m - R(1.0), R(0.0)));
}
TIEROD_INLINE real tierod_log1p(real x) {
    const real u = R(1.0) + x;
    real m;
    const real k = tierod_split(u, &m), c = tierod_sum_error(R(1.0), x, u) / u;
    const real f = k == R(0.0) ? x : m - R(1.0), f_low = k == R(0.0) ? R(0.0) : c;
    const real v = tierod_log_of_parts(k, f, f_low);
    return x == R(0.0) ? x : tierod_log_of_value(u, v);
}

/*** power ***/
TIEROD_INLINE real tierod_pow(real x, real y) {
    const real infinite = (real)INFINITY, ax = M(fabs)(x), ay = M(fabs)(y);
    real m;
    const real k = tierod_split(ax, &m), f = m - R(1.0), g = R(2.0) + f;
    /* log(1 + f) = 2 s + 2/3 s^3 + ..., s = f / (2 + f), each with what it lacks. */
    const real s = f / g, sg = s * g;
    const real s_low = ((f - sg) - tierod_product_error(s, g, sg) - s * tierod_sum_error(R(2.0), f, g)) / g;
    const real z = s * s, z_low = tierod_product_error(s, s, z) + R(2.0) * s * s_low;
    const real w = z * @TWO_THIRDS@, w_low = tierod_product_error(z, @TWO_THIRDS@, w) + (z * @TWO_THIRDS_LOW@ + z_low * @TWO_THIRDS@);
@POLYNOMIAL p z POWER@
    const real v = R(2.0) + w, v_low = tierod_sum_error(R(2.0), w, v) + (w_low + z * z * p);
    const real a = s * v, a_low = tierod_product_error(s, v, a) + (s * v_low + s_low * v);
    const real b = k * @LN2@, c = b + a;
    const real c_low = tierod_sum_error(b, a, c) + (a_low + k * @LN2_LOW@);
    const real l = c + c_low, l_low = c_low - (l - c);
    /* Beyond 2^66 every power is that of 2^66. */
    const real times = ay > @LARGEST_POWER@ ? tierod_signed(@LARGEST_POWER@, y) : y, e = times * l;
    const real far = e > R(2000.0) ? R(2000.0) : e < -R(2000.0) ? -R(2000.0) : e;
    const real e_low = far == e ? tierod_product_error(times, l, e) + times * l_low : R(0.0);
    const real size = tierod_scaled_exp(far, e_low, R(0.0));
    /* At the ends: of zero and of infinity, and to infinity. */
    const int outside = (ax == R(0.0)) | (ax == infinite) | ((ay == infinite) & (ax != R(1.0)));
    const real at_end = (ax < R(1.0)) == (y < R(0.0)) ? infinite : R(0.0);
    const real positive = outside ? at_end : ay == infinite ? R(1.0) : size;
    /* Of a negative number. */
    const real half = R(0.5) * ay;
    const int is_whole = !(ay < @WHOLE_FROM@) | ((ay + @WHOLE_FROM@) - @WHOLE_FROM@ == ay);
    const int is_odd = is_whole & (half < @WHOLE_FROM@) & ((half + @WHOLE_FROM@) - @WHOLE_FROM@ != half);
    const int negative = (tierod_bits(x) & TIEROD_SIGN) != 0;
    const real value = (negative & is_odd) ? -positive : positive;
    const real defined = ((x < R(0.0)) & !is_whole & (ax < infinite)) ? (real)NAN : value;
    return ((x == R(1.0)) | (y == R(0.0))) ? R(1.0) : ((x != x) | (y != y)) ? x + y : defined;
}

/*** length ***/
TIEROD_INLINE real tierod_hypot(real a, real b) {
    const real infinite = (real)INFINITY, x = M(fabs)(a), y = M(fabs)(b), most = x < y ? y : x;
    const real down = most > @LENGTH_LARGE@ ? @LENGTH_DOWN@ : most < @LENGTH_SMALL@ ? @LENGTH_UP@ : R(1.0);
    const real back = most > @LENGTH_LARGE@ ? @LENGTH_UP@ : most < @LENGTH_SMALL@ ? @LENGTH_DOWN@ : R(1.0);
    const real p = x * down, q = y * down, v = M(sqrt)(tierod_fma(p, p, q * q)) * back;
    return ((x == infinite) | (y == infinite)) ? infinite : v;
}
