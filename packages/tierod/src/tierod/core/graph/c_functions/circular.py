"""C of sine, cosine, tangent and their inverses, without a branch."""

from __future__ import annotations

from tierod.core.graph.c_functions.number import DOUBLE, Real, polynomial

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
