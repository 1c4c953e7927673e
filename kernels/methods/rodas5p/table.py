"""The coefficients of Rodas5P, for stages from which the products with the Jacobian are removed.

G. Steinebach, "Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the
Julia Differential Equations package", BIT Numer. Math. 63:27 (2023).  The numbers are those of the
author's package, in the form A = alpha / Gamma and C = 1 / gamma - 1 / Gamma of E. Hairer and G.
Wanner, "Solving Ordinary Differential Equations II", section IV.7.
"""

from fractions import Fraction

from ..tableau import Row, rows

N_STAGES = 8
GAMMA = 0.21193756319429014

# Coefficients of the states of stages 2 to 6.  The state of a later stage is the state of the stage
# before, plus the stage before.
A = rows(
    """
    3;
    2.849394379747939 .45842242204463923;
    -6.954028509809101 2.489845061869568 -10.358996098473584;
    2.8029986275628964 .5072464736228206 -.3988312541770524 -.04721187230404641;
    -7.502846399306121 2.561846144803919 -11.627539656261098 -.18268767659942256
        .030198172008377946
    """
)
C = rows(
    """
    -14.155112264123755;
    -17.97296035885952 -2.859693295451294;
    147.12150275711716 -1.41221402718213 71.68940251302358;
    165.43517024871676 -.4592823456491126 42.90938336958603 -5.961986721573306;
    24.854864614690072 -3.0009227002832186 47.4931110020768 5.5814197821558125
        -.6610691825249471;
    30.91273214028599 -3.1208243349937974 77.79954646070892 34.28646028294783
        -19.097331116725623 -28.087943162872662;
    37.80277123390563 -3.2571969029072276 112.26918849496327 66.9347231244047
        -40.06618937091002 -54.66780262877968 -9.48861652309627
    """
)
# Coefficients of the states of all stages, from stage 1 on, and of the state at the end.
STAGE_ROWS = tuple([row.floats for row in A] + [(*A[-1].floats, *[1.0] * k) for k in (1, 2)])
END_ROW = (*A[-1].floats, 1.0, 1.0, 1.0)
TIMES = Row(".6358126895828704 .4095798393397535 .9769306725060716 .4288403609558664 1 1 1")
SLOPES = Row(  # factors of df/dt; 0 from stage 6 on
    """
    .21193756319429014 -.42387512638858027 -.3384627126235924 1.8046452872882734
    2.325825639765069 0 0 0
    """
)


def _end():
    """The b_i of y_1 = y_0 + sum(b_i k_i) over gamma, from the weights m of the stages in y_1.

    The b_i solve b (1 / gamma - C) = m; the last b_i is 1.
    """
    m = [*A[-1].exact, 1, 1, 1]
    found = []
    for j in reversed(range(8)):
        later = zip(reversed(found), C[j:], strict=True)
        found.append(m[j] + Fraction(GAMMA) * sum(x * row.exact[j] for x, row in later))
    return Row.of(map(float, reversed(found[1:])))


END = _end()
DENSE = rows(
    """
    25.948786856663858 -2.5579724845846235 10.433815404888879 -2.3679251022685204
        .524948541321073 1.1241088310450404 .4272876194431874 -.17202221070155493;
    -9.91568850695171 -.9689944594115154 3.0438037242978453 -24.495224566215796
        20.176138334709044 15.98066361424651 -6.789040303419874 -6.710236069923372;
    11.419903575922262 2.8879645146136994 72.92137995996029 80.12511834622643
        -52.072871366152654 -59.78993625266729 -.15582684282751913 4.883087185713722
    """
)
