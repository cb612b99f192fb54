"""The C that every kernel begins with: one real type, and tierod's own mathematical functions.

Only square root, absolute value and rounding, which are instructions, are taken from the C library. The functions have
no branch, so that a loop over lanes vectorises where they occur, and are the same in every driver. Their error is at
most two units in the last place."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from tierod.core.graph.c_reals import (
    ALWAYS_INLINE,
    DOUBLE,
    FLOAT,
    HEAD,
    INLINE,
    SIGN,
    Real,
    bits,
    exact,
    polynomial,
    reduction,
)

_SINE = {
    True: (
        -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04,
        2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10,
    ),
    False: (-1.6666654611e-1, 8.3321608736e-3, -1.9515295891e-4),
}  # fmt: skip
_COSINE = {
    True: (
        4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05,
        -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11,
    ),
    False: (4.166664568298827e-2, -1.388731625493765e-3, 2.443315711809948e-5),
}  # fmt: skip
_ARCTANGENT = {
    True: (
        -3.33333333333329318027e-01, 1.99999999998764832476e-01, -1.42857142725034663711e-01,
        1.11111104054623557880e-01, -9.09088713343650656196e-02, 7.69187620504482999495e-02,
        -6.66107313738753120669e-02, 5.83357013379057348645e-02, -4.97687799461593236017e-02,
        3.65315727442169155270e-02, -1.62858201153657823623e-02,
    ),
    False: (-3.33329491539e-1, 1.99777106478e-1, -1.38776856032e-1, 8.05374449538e-2),
}  # fmt: skip
"""Coefficients: in double of Sun's fdlibm (k_sin.c, k_cos.c, s_atan.c), in float of Moshier's Cephes (sinf, atanf)."""

_HALF = {True: (0.4636476090008061, 2.2698777452961687e-17), False: (0.46364760398864746, 5.01215868808913e-09)}
_QUARTER_PI = {True: (0.7853981633974483, 3.061616997868383e-17), False: (0.7853981852531433, -2.1855694143368964e-08)}
_PI = {True: (3.141592653589793, 1.2246467991473532e-16), False: (3.1415927410125732, -8.742277657347586e-08)}
"""arctan(1/2), pi/4 and pi, each as the nearest number and the remainder."""


def sine_and_cosine(real: Real) -> str:
    """C of sine and cosine within a quarter turn around zero, and of sine, cosine and tangent of any angle."""
    double = real is DOUBLE
    return f"""\
/* Of x + y within an eighth of a turn, the y small beside x; lost: what the result lacks. */
TIEROD_INLINE real tierod_sine_near(real x, real y, real *lost) {{
    const real z = x * x;
{polynomial(real, "p", "z", _SINE[double])}\
    const real less = tierod_fma(-(x * z), p, R(0.5) * z * y - y), v = x - less;
    *lost = (x - v) - less;
    return v;
}}
TIEROD_INLINE real tierod_cosine_near(real x, real y, real *lost) {{
    const real z = x * x, half = R(0.5) * z, w = R(1.0) - half;
{polynomial(real, "p", "z", _COSINE[double])}\
    const real more = ((R(1.0) - w) - half) + tierod_fma(z * z, p, -x * y), v = w + more;
    *lost = (w - v) + more;
    return v;
}}
TIEROD_INLINE real tierod_sin(real x) {{
    real rest, tail, lost;
    const tierod_word turns = tierod_reduced(x, &rest, &tail);
    const real s = tierod_sine_near(rest, tail, &lost), c = tierod_cosine_near(rest, tail, &lost);
    const real v = turns & 1 ? c : s;
    return turns & 2 ? -v : v;
}}
TIEROD_INLINE real tierod_cos(real x) {{
    real rest, tail, lost;
    const tierod_word turns = tierod_reduced(x, &rest, &tail);
    const real s = tierod_sine_near(rest, tail, &lost), c = tierod_cosine_near(rest, tail, &lost);
    const real v = turns & 1 ? s : c;
    return (turns + 1) & 2 ? -v : v;
}}
TIEROD_INLINE real tierod_tan(real x) {{
    real rest, tail, s_low, c_low;
    const tierod_word turns = tierod_reduced(x, &rest, &tail);
    const real s = tierod_sine_near(rest, tail, &s_low), c = tierod_cosine_near(rest, tail, &c_low);
    const real a = turns & 1 ? c : s, b = turns & 1 ? s : c, v = a / b, back = v * b;
    const real a_low = turns & 1 ? c_low : s_low, b_low = turns & 1 ? s_low : c_low;
    const real w = v - (((back - a) + tierod_product_error(v, b, back) - a_low) + v * b_low) / b;
    return turns & 1 ? -w : w;
}}
"""


def arctangent(real: Real) -> str:
    """C of atan2, the angle of a point, and of atan, asin and acos, which use it."""
    double = real is DOUBLE
    half, quarter, pi = (tuple(map(real.number, values[double])) for values in (_HALF, _QUARTER_PI, _PI))
    large, small = (real.number(2.0**power) for power in ((900, -900) if double else (100, -100)))
    up, down = (real.number(2.0**power) for power in ((200, -200) if double else (50, -50)))
    return f"""\
TIEROD_INLINE real tierod_atan2(real y, real x) {{
    const real infinite = (real)INFINITY, ay = M(fabs)(y), ax = M(fabs)(x);
    const real least = ay < ax ? ay : ax, most = ay < ax ? ax : ay;
    const real scale = most > {large} ? {down} : most < {small} ? {up} : R(1.0);
    const int diagonal = (ax == infinite) & (ay == infinite);
    const real n = diagonal ? R(1.0) : least * scale;
    const real d = (diagonal | (most == R(0.0))) ? R(1.0) : most * scale;
    /* The angle from that of 0, 1/2 or 1, whichever lies near. */
    const int near_one = n > R(0.68) * d, near_half = n > R(0.4) * d;
    const real up_by = near_one ? n - d : near_half ? R(2.0) * n - d : n;
    const real t = up_by / (near_one ? n + d : near_half ? R(2.0) * d + n : d), z = t * t;
    const real a = near_one ? {quarter[0]} : near_half ? {half[0]} : R(0.0);
    const real a_low = near_one ? {quarter[1]} : near_half ? {half[1]} : R(0.0);
{polynomial(real, "p", "z", _ARCTANGENT[double])}\
    const real small = tierod_fma(t * z, p, t);
    /* Into the quadrant: b + s * angle. */
    const int steep = ay > ax, back = (tierod_bits(x) & TIEROD_SIGN) != 0;
    const real b = steep ? {real.number(0.5 * _PI[double][0])} : back ? {pi[0]} : R(0.0);
    const real b_low = steep ? {real.number(0.5 * _PI[double][1])} : back ? {pi[1]} : R(0.0);
    const real s = steep != back ? -R(1.0) : R(1.0), whole = b + s * a;
    const real low = tierod_sum_error(b, s * a, whole) + tierod_fma(s, a_low, b_low);
    return tierod_signed(whole + (low + s * small), y);
}}
TIEROD_INLINE real tierod_atan(real x) {{ return tierod_atan2(x, R(1.0)); }}
TIEROD_INLINE real tierod_asin(real x) {{
    const real square = M(fabs)(x) < R(0.5) ? tierod_fma(-x, x, R(1.0)) : (R(1.0) - x) * (R(1.0) + x);
    return tierod_atan2(x, M(sqrt)(square));
}}
TIEROD_INLINE real tierod_acos(real x) {{ return R(2.0) * tierod_atan(M(sqrt)((R(1.0) - x) / (R(1.0) + x))); }}
"""


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


_PARTS: dict[str, tuple[Callable[[Real], str], ...]] = {
    "circular": (bits, exact, reduction, sine_and_cosine),
    "arctangent": (bits, exact, arctangent),
    "exponential": (bits, exact, exponential),
    "logarithm": (bits, exact, logarithm),
    "power": (bits, exact, exponential, logarithm, power),
    "length": (length,),
}
"""C that each group of functions needs, in order."""

_GROUPS = {
    **dict.fromkeys(("sin", "cos", "tan"), "circular"),
    **dict.fromkeys(("asin", "acos", "atan", "atan2"), "arctangent"),
    **dict.fromkeys(("exp", "expm1", "sinh", "cosh", "tanh"), "exponential"),
    **dict.fromkeys(("log", "log1p"), "logarithm"),
    "pow": "power",
    "hypot": "length",
}

OWN = {name: f"tierod_{name}" for name in ("sign", *_GROUPS)}
"""Names of tierod's own C functions, by the name of the operation."""


def prelude(operations: Iterable[str], in_lanes: bool = False) -> str:
    """Head of a kernel: types, and the functions that the kernel uses, in double and in float.

    Args:
        operations: names of the operations that are printed
        in_lanes: whether a loop that must vectorise uses them
    """
    ordered = _ordered(operations)
    head = HEAD + (ALWAYS_INLINE if in_lanes else "") + INLINE + SIGN
    if not ordered:
        return head
    texts = ["".join(part(real) for part in ordered) for real in (FLOAT, DOUBLE)]
    return f"{head}#ifdef TIEROD_FLOAT32\n{texts[0]}#else\n{texts[1]}#endif\n"


def definitions(operations: Iterable[str], single: bool) -> str:
    """The functions alone, in one precision; `tierod_fma`, which multiplies and adds, is left to the caller.

    Args:
        operations: names of the operations that are printed
        single: whether in float, else in double
    """
    return "".join(part(FLOAT if single else DOUBLE) for part in _ordered(operations))


def _ordered(operations: Iterable[str]) -> list[Callable[[Real], str]]:
    groups = {_GROUPS[name] for name in operations if name in _GROUPS}
    wanted = {part for group in groups for part in _PARTS[group]}
    return list(dict.fromkeys(part for parts in _PARTS.values() for part in parts if part in wanted))
