"""Coefficients of the kernels, by ``scripts/kernel_coefficients.py``: do not edit."""

EXPM1 = (
    float.fromhex("0x1.0000000000001p-1"),
    float.fromhex("0x1.5555555555557p-3"),
    float.fromhex("0x1.5555555554d3fp-5"),
    float.fromhex("0x1.11111111100eap-7"),
    float.fromhex("0x1.6c16c16f0998ep-10"),
    float.fromhex("0x1.a01a01abe1342p-13"),
    float.fromhex("0x1.a019f398df348p-16"),
    float.fromhex("0x1.71de024523cadp-19"),
    float.fromhex("0x1.280222c8b0557p-22"),
    float.fromhex("0x1.af4dc3fdc29e0p-26"),
    float.fromhex("0x1.e631f3fec67b6p-30"),
)
"""expm1(r) = r + r^2 p(r), |r| <= ln(2)/2;
relative error 2^-58.4 before rounding."""
EXP2 = (
    float.fromhex("0x1.62e42fefa39efp-1"),
    float.fromhex("0x1.ebfbdff82c5a4p-3"),
    float.fromhex("0x1.c6b08d7049fe8p-5"),
    float.fromhex("0x1.3b2ab6fba011ap-7"),
    float.fromhex("0x1.5d87fe78cd6b2p-10"),
    float.fromhex("0x1.4309130ed8d05p-13"),
    float.fromhex("0x1.ffcbfba988e74p-17"),
    float.fromhex("0x1.62bfc79d35ea0p-20"),
    float.fromhex("0x1.b5267cd05c9d2p-24"),
    float.fromhex("0x1.e61b4fcfc3a79p-28"),
    float.fromhex("0x1.e79bccebe8b31p-32"),
)
"""2^r = 1 + r p(r), |r| <= 1/2;
relative error 2^-58.0 before rounding."""
LOG = (
    float.fromhex("0x1.5555555555592p-1"),
    float.fromhex("0x1.999999997fedfp-2"),
    float.fromhex("0x1.24924941e1458p-2"),
    float.fromhex("0x1.c71c5215e5fccp-3"),
    float.fromhex("0x1.74663c678aab7p-3"),
    float.fromhex("0x1.39a1f9b1eb5cbp-3"),
    float.fromhex("0x1.2f02f7fea2ea1p-3"),
)
"""log((1 + s)/(1 - s)) = 2 s + s z p(z), z = s^2, sqrt(1/2) <= quotient <= sqrt(2);
relative error 2^-59.5 before rounding."""
LOG_LONG = (
    float.fromhex("0x1.9999999999996p-2"),
    float.fromhex("0x1.249249249302cp-2"),
    float.fromhex("0x1.c71c71c58155ep-3"),
    float.fromhex("0x1.745d1831e7c2dp-3"),
    float.fromhex("0x1.3b1362d102b3fp-3"),
    float.fromhex("0x1.1120b1c71c371p-3"),
    float.fromhex("0x1.de3406055d56ep-4"),
    float.fromhex("0x1.eb0c79dc73246p-4"),
)
"""the same = 2 s + 2/3 s z + s z^2 p(z), for the logarithm in two parts;
relative error 2^-73.6 before rounding."""
SIN = (
    float.fromhex("-0x1.5555555555548p-3"),
    float.fromhex("0x1.111111110f7d0p-7"),
    float.fromhex("-0x1.a01a019bfdeb4p-13"),
    float.fromhex("0x1.71de3567cdf91p-19"),
    float.fromhex("-0x1.ae5e5a8c79e2ep-26"),
    float.fromhex("0x1.5d8fd012a8d64p-33"),
)
"""sin(r) = r + r z p(z), z = r^2, |r| <= pi/4;
relative error 2^-57.9 before rounding."""
COS = (
    float.fromhex("0x1.555555555554bp-5"),
    float.fromhex("-0x1.6c16c16c14f91p-10"),
    float.fromhex("0x1.a01a019c844eep-16"),
    float.fromhex("-0x1.27e4f7eac2e09p-22"),
    float.fromhex("0x1.1ee9d7b2ec07ep-29"),
    float.fromhex("-0x1.8fa498c1cbf2cp-37"),
)
"""cos(r) = 1 - z/2 + z^2 p(z), z = r^2, |r| <= pi/4;
relative error 2^-64.0 before rounding."""
ATAN = (
    float.fromhex("-0x1.555555555553dp-2"),
    float.fromhex("0x1.99999999957cep-3"),
    float.fromhex("-0x1.24924922aa518p-3"),
    float.fromhex("0x1.c71c70e50f553p-4"),
    float.fromhex("-0x1.745cf8c38d60cp-4"),
    float.fromhex("0x1.3b1117969e757p-4"),
    float.fromhex("-0x1.10eba8d6b7a78p-4"),
    float.fromhex("0x1.df0e80e06185ap-5"),
    float.fromhex("-0x1.9ccf81c87b9bfp-5"),
    float.fromhex("0x1.37ce268e5fbb8p-5"),
    float.fromhex("-0x1.255b4c6e0a9a0p-6"),
)
"""atan(t) = t + t z p(z), z = t^2, |t| <= tan(pi/8);
relative error 2^-59.4 before rounding."""
ASIN = (
    float.fromhex("0x1.5555555555577p-3"),
    float.fromhex("0x1.333333332e102p-4"),
    float.fromhex("0x1.6db6db7214269p-5"),
    float.fromhex("0x1.f1c71a9467458p-6"),
    float.fromhex("0x1.6e8bdeed879acp-6"),
    float.fromhex("0x1.1c49ef89a2eb3p-6"),
    float.fromhex("0x1.ca1f9f46580a4p-7"),
    float.fromhex("0x1.7585043e81685p-7"),
    float.fromhex("0x1.613f3f65519c2p-7"),
    float.fromhex("0x1.e5cf87d31759ep-9"),
    float.fromhex("0x1.63a74a4b1b57dp-6"),
    float.fromhex("-0x1.580bf70937a62p-6"),
    float.fromhex("0x1.0b4b085e0df4ap-5"),
)
"""asin(t) = t + t z p(z), z = t^2, |t| <= 1/2;
relative error 2^-59.9 before rounding."""
ERF = (
    float.fromhex("0x1.20dd750429b6dp+0"),
    float.fromhex("-0x1.812746b0379e6p-2"),
    float.fromhex("0x1.ce2f21a042b20p-4"),
    float.fromhex("-0x1.b82ce3128499cp-6"),
    float.fromhex("0x1.565bcd0db02e0p-8"),
    float.fromhex("-0x1.c02db3d8ed155p-11"),
    float.fromhex("0x1.f9a321a11b609p-14"),
    float.fromhex("-0x1.f4d1df390c849p-17"),
    float.fromhex("0x1.b9def199fcfc5p-20"),
    float.fromhex("-0x1.5f1d369a0e201p-23"),
    float.fromhex("0x1.f7a4103ba4f2ep-27"),
    float.fromhex("-0x1.386aba0706cd3p-30"),
    float.fromhex("0x1.057996bcdb954p-34"),
)
"""erf(x) = x p(x^2), |x| <= 1;
relative error 2^-62.7 before rounding."""
ERFC = (
    float.fromhex("0x1.058671b52c776p-2"),
    float.fromhex("-0x1.b57034efd3f73p-2"),
    float.fromhex("0x1.eeea7dc8a78b3p-3"),
    float.fromhex("-0x1.437f0b68c0b3ap-4"),
    float.fromhex("0x1.e94715979e7cdp-9"),
    float.fromhex("0x1.ca95ed52f23d4p-8"),
    float.fromhex("-0x1.bc25a47ac7c0ap-11"),
    float.fromhex("-0x1.016b5cb7e1301p-10"),
    float.fromhex("0x1.6d5ef4dcd64ffp-15"),
    float.fromhex("0x1.6da958e88ce61p-13"),
    float.fromhex("0x1.cdcd5a22fedfep-16"),
    float.fromhex("-0x1.ceaeb1946af58p-16"),
    float.fromhex("-0x1.d4c5914e34028p-17"),
    float.fromhex("0x1.73414f18f1a46p-20"),
    float.fromhex("0x1.ff5f980922569p-19"),
    float.fromhex("0x1.3faa4253812d3p-20"),
    float.fromhex("-0x1.3e5e6d8573b2ap-21"),
    float.fromhex("-0x1.98f28973ccacap-22"),
)
"""erfc(x) = exp(-x^2) p(u), u = (x - 2)/(x + 2), 1 <= x <= 6;
relative error 2^-59.9 before rounding."""
LN2 = (float.fromhex("0x1.62e42fefa39efp-1"), float.fromhex("0x1.abc9e3b39803fp-56"))
"""ln(2), its top 53 bits and the next."""
LOG2_E = float.fromhex("0x1.71547652b82fep+0")
"""1/ln(2)."""
TWO_THIRDS = (float.fromhex("0x1.5555555555555p-1"), float.fromhex("0x1.5555555555555p-55"))
"""2/3, its top 53 bits and the next."""
TWO_OVER_LN2 = (float.fromhex("0x1.71547652b82fep+1"), float.fromhex("0x1.777d0ffda0d24p-55"))
"""2/ln(2), its top 53 bits and the next."""
INVERSE_LN2 = (float.fromhex("0x1.71547652b82fep+0"), float.fromhex("0x1.777d0ffda0d24p-56"))
"""1/ln(2), its top 53 bits and the next."""
HALF_PI = (
    float.fromhex("0x1.921fb54442d18p+0"),
    float.fromhex("0x1.1a62633145c07p-54"),
    float.fromhex("-0x1.f1976b7ed8fbcp-110"),
)
"""pi/2, three times 53 bits."""
TWO_OVER_PI = float.fromhex("0x1.45f306dc9c883p-1")
"""2/pi."""
QUARTER_PI = (float.fromhex("0x1.921fb54442d18p-1"), float.fromhex("0x1.1a62633145c07p-55"))
"""pi/4, twice 53 bits."""
