"""C of exponential function, logarithm, power, hyperbolic functions and vector length, without a branch."""

from __future__ import annotations

import math

from tierod.core.graph.c_functions.number import DOUBLE, Real, polynomial

_LN2 = {True: (6.93147180369123816490e-01, 1.90821492927058770002e-10), False: (0.693359375, -2.12194440e-4)}
_EXPONENTIAL = {
    True: tuple(1.0 / math.factorial(n) for n in range(2, 14)),
    False: (5.0000001201e-1, 1.6666665459e-1, 4.1665795894e-2, 8.3334519073e-3, 1.3981999507e-3, 1.9875691500e-4),
}
"""Coefficients of (exp(r) - 1 - r) / r^2 for |r| <= ln(2)/2: Taylor series, in float of Moshier's Cephes (expf.c)."""

_LOGARITHM = {
    True: (
        6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
        1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
    ),
    False: (0.66666662693, 0.40000972152, 0.28498786688, 0.24279078841),
}  # fmt: skip
"""Coefficients of (log(1 + f) - 2 s) / s^3 with s = f / (2 + f), of Sun's fdlibm (e_log.c, e_logf.c)."""

_TANH = {
    True: (
        (-1.61468768441708447952e3, -9.92877231001918586564e1, -9.64399179425052238628e-1),
        (4.84406305325125486048e3, 2.23548839060100448583e3, 1.12811678491632931402e2, 1.0),
    ),
    False: ((-3.33332819422e-1, 1.33314422036e-1, -5.37397155531e-2, 2.06390887954e-2, -5.70498872745e-3), (1.0,)),
}
"""Numerator and denominator of (tanh(x) - x) / x^3 for |x| < 0.625, of Moshier's Cephes (tanh.c, tanhf.c)."""

_SINH = tuple(1.0 / math.factorial(2 * n + 1) for n in range(1, 10))
"""Coefficients of (sinh(x) - x) / x^3 in powers of x^2, Taylor series."""

_TWO_THIRDS = {True: (0.6666666666666666, 3.700743415417188e-17), False: (0.6666666865348816, -1.9868215517249155e-08)}
_LOWEST, _HIGHEST = {True: -745.2, False: -104.0}, {True: 709.782712893384, False: 88.72283172607422}


def exponential(real: Real) -> str:
    """C of exp(x), exp(x) - 1, tanh(x), sinh(x) and cosh(x)."""
    double = real is DOUBLE
    high, low = map(real.number, _LN2[double])
    lowest, highest = real.number(_LOWEST[double]), real.number(_HIGHEST[double])
    most = real.number(float(real.fraction + 10))
    above, below = _TANH[double]
    return f"""\
/* exp(x + tail) / 2^halvings, the tail small beside x. */
TIEROD_INLINE real tierod_scaled_exp(real x, real tail, real halvings) {{
    const real y = x > {highest} + R(1.0) ? {highest} + R(1.0) : x < {lowest} ? {lowest} : x;
    const real k = tierod_fma(y, R(1.4426950408889634), TIEROD_WHOLE) - TIEROD_WHOLE;
    const real r = tierod_fma(-k, {low}, tierod_fma(-k, {high}, y)) + tail;
{polynomial(real, "p", "r", _EXPONENTIAL[double])}\
    const real e = R(1.0) + tierod_fma(r * r, p, r);
    /* In two steps: where the result is subnormal or near the largest, its power of two alone is no number. */
    const real half = tierod_fma(k, R(0.5), TIEROD_WHOLE) - TIEROD_WHOLE;
    const real v = e * tierod_power_of_two(half) * tierod_power_of_two(k - half - halvings);
    return x > {highest} + R(0.6931471805599453) * halvings ? (real)INFINITY : x < {lowest} ? R(0.0) : v;
}}
TIEROD_INLINE real tierod_exp(real x) {{ return tierod_scaled_exp(x, R(0.0), R(0.0)); }}
TIEROD_INLINE real tierod_expm1(real x) {{
    const real y = x > {highest} + R(1.0) ? {highest} + R(1.0) : x < R(-50.0) ? R(-50.0) : x;
    const real k = tierod_fma(y, R(1.4426950408889634), TIEROD_WHOLE) - TIEROD_WHOLE;
    const real far = tierod_fma(-k, {high}, y), r = tierod_fma(-k, {low}, far);
    const real tail = tierod_fma(-k, {low}, far - r);
{polynomial(real, "p", "r", _EXPONENTIAL[double])}\
    const real half = tierod_fma(k, R(0.5), TIEROD_WHOLE) - TIEROD_WHOLE;
    /* 2^k (1 - 2^-k + exp(r) - 1) */
    const real less = k > {most} ? R(0.0) : tierod_power_of_two(-half) * tierod_power_of_two(half - k);
    const real c = R(1.0) - less, t = c + r;
    const real e = t + (tierod_sum_error(c, r, t) + tierod_fma(r * r, p, tail));
    const real v = e * tierod_power_of_two(half) * tierod_power_of_two(k - half);
    return x > {highest} ? (real)INFINITY : x == R(0.0) ? x : v;
}}
TIEROD_INLINE real tierod_tanh(real x) {{
    const real a = M(fabs)(x), z = x * x, e = tierod_exp(R(2.0) * a);
{polynomial(real, "n", "z", above)}{polynomial(real, "d", "z", below)}\
    const real q = (a < R(0.625) ? z * n : R(2.0)) / (a < R(0.625) ? d : e + R(1.0));
    return tierod_signed(a < R(0.625) ? tierod_fma(a, q, a) : R(1.0) - q, x);
}}
TIEROD_INLINE real tierod_sinh(real x) {{
    const real a = M(fabs)(x), z = x * x, h = tierod_scaled_exp(a, R(0.0), R(1.0));
{polynomial(real, "p", "z", _SINH[: 9 if double else 5])}\
    return a < R(1.0) ? tierod_fma(x * z, p, x) : tierod_signed(h - R(0.25) / h, x);
}}
TIEROD_INLINE real tierod_cosh(real x) {{
    const real h = tierod_scaled_exp(M(fabs)(x), R(0.0), R(1.0));
    return h + R(0.25) / h;
}}
"""


def logarithm(real: Real) -> str:
    """C of log(x) and log(1 + x)."""
    double = real is DOUBLE
    high, low = map(real.number, _LN2[double])
    mean = real.number(math.sqrt(0.5))
    return f"""\
/* x = 2^k m with m in [sqrt(1/2), sqrt(2)). */
TIEROD_INLINE real tierod_split(real x, real *m) {{
    const int subnormal = x < {real.number(real.least)};
    const tierod_word b = tierod_bits(subnormal ? x * {real.number(2.0 ** (real.fraction + 2))} : x);
    const tierod_word e = (b + (tierod_bits(R(1.0)) - tierod_bits({mean}))) >> {real.fraction};
    *m = tierod_number(b - (e << {real.fraction}) + tierod_bits(R(1.0)));
    return tierod_number(tierod_bits(TIEROD_WHOLE) + e) - TIEROD_WHOLE
        - (subnormal ? {real.number(real.bias + real.fraction + 2.0)} : {real.number(float(real.bias))});
}}
TIEROD_INLINE real tierod_log_of_value(real x, real v) {{
    const real infinite = (real)INFINITY;
    return x > R(0.0) ? (x < infinite ? v : x) : x == R(0.0) ? -infinite : (real)NAN;
}}
/* log(2^k (1 + f)), f with an error c. */
TIEROD_INLINE real tierod_log_of_parts(real k, real f, real c) {{
    const real s = f / (R(2.0) + f), z = s * s, half = R(0.5) * f * f;
{polynomial(real, "p", "z", _LOGARITHM[double])}\
    return k * {high} - ((half - (s * (half + z * p) + (k * {low} + c))) - f);
}}
TIEROD_INLINE real tierod_log(real x) {{
    real m;
    const real k = tierod_split(x, &m);
    return tierod_log_of_value(x, tierod_log_of_parts(k, m - R(1.0), R(0.0)));
}}
TIEROD_INLINE real tierod_log1p(real x) {{
    const real u = R(1.0) + x;
    real m;
    const real k = tierod_split(u, &m), c = tierod_sum_error(R(1.0), x, u) / u;
    const real f = k == R(0.0) ? x : m - R(1.0), f_low = k == R(0.0) ? R(0.0) : c;
    const real v = tierod_log_of_parts(k, f, f_low);
    return x == R(0.0) ? x : tierod_log_of_value(u, v);
}}
"""


def power(real: Real) -> str:
    """C of x^y: the logarithm with twice the digits, times y, then the exponential function."""
    double = real is DOUBLE
    high, low = map(real.number, _LN2[double])
    rest = tuple(2.0 / (2 * n + 1) for n in range(2, 14 if double else 7))
    third, third_low = map(real.number, _TWO_THIRDS[double])
    count, largest = real.number(2.0**real.fraction), real.number(2.0**66)
    return f"""\
TIEROD_INLINE real tierod_pow(real x, real y) {{
    const real infinite = (real)INFINITY, ax = M(fabs)(x), ay = M(fabs)(y);
    real m;
    const real k = tierod_split(ax, &m), f = m - R(1.0), g = R(2.0) + f;
    /* log(1 + f) = 2 s + 2/3 s^3 + ..., s = f / (2 + f), each with what it lacks. */
    const real s = f / g, sg = s * g;
    const real s_low = ((f - sg) - tierod_product_error(s, g, sg) - s * tierod_sum_error(R(2.0), f, g)) / g;
    const real z = s * s, z_low = tierod_product_error(s, s, z) + R(2.0) * s * s_low;
    const real w = z * {third}, w_low = tierod_product_error(z, {third}, w) + (z * {third_low} + z_low * {third});
{polynomial(real, "p", "z", rest)}\
    const real v = R(2.0) + w, v_low = tierod_sum_error(R(2.0), w, v) + (w_low + z * z * p);
    const real a = s * v, a_low = tierod_product_error(s, v, a) + (s * v_low + s_low * v);
    const real b = k * {high}, c = b + a;
    const real c_low = tierod_sum_error(b, a, c) + (a_low + k * {low});
    const real l = c + c_low, l_low = c_low - (l - c);
    /* Beyond 2^66 every power is that of 2^66. */
    const real times = ay > {largest} ? tierod_signed({largest}, y) : y, e = times * l;
    const real far = e > R(2000.0) ? R(2000.0) : e < -R(2000.0) ? -R(2000.0) : e;
    const real e_low = far == e ? tierod_product_error(times, l, e) + times * l_low : R(0.0);
    const real size = tierod_scaled_exp(far, e_low, R(0.0));
    /* At the ends: of zero and of infinity, and to infinity. */
    const int outside = (ax == R(0.0)) | (ax == infinite) | ((ay == infinite) & (ax != R(1.0)));
    const real at_end = (ax < R(1.0)) == (y < R(0.0)) ? infinite : R(0.0);
    const real positive = outside ? at_end : ay == infinite ? R(1.0) : size;
    /* Of a negative number. */
    const real half = R(0.5) * ay;
    const int is_whole = !(ay < {count}) | ((ay + {count}) - {count} == ay);
    const int is_odd = is_whole & (half < {count}) & ((half + {count}) - {count} != half);
    const int negative = (tierod_bits(x) & TIEROD_SIGN) != 0;
    const real value = (negative & is_odd) ? -positive : positive;
    const real defined = ((x < R(0.0)) & !is_whole & (ax < infinite)) ? (real)NAN : value;
    return ((x == R(1.0)) | (y == R(0.0))) ? R(1.0) : ((x != x) | (y != y)) ? x + y : defined;
}}
"""


def length(real: Real) -> str:
    """C of the length of a vector of two components, scaled against overflow and underflow."""
    double = real is DOUBLE
    large, small = (real.number(2.0**exponent) for exponent in ((500, -450) if double else (60, -50)))
    up, down = (real.number(2.0**exponent) for exponent in ((600, -600) if double else (80, -80)))
    return f"""\
TIEROD_INLINE real tierod_hypot(real a, real b) {{
    const real infinite = (real)INFINITY, x = M(fabs)(a), y = M(fabs)(b), most = x < y ? y : x;
    const real down = most > {large} ? {down} : most < {small} ? {up} : R(1.0);
    const real back = most > {large} ? {up} : most < {small} ? {down} : R(1.0);
    const real p = x * down, q = y * down, v = M(sqrt)(tierod_fma(p, p, q * q)) * back;
    return ((x == infinite) | (y == infinite)) ? infinite : v;
}}
"""
