"""Names of variables as a blackboard has them: θ₁ for th1, theta1 and theta_1."""

import re

SHORT = {"th": "theta", "ph": "phi", "ps": "psi", "om": "omega"}
GREEK = dict(
    alpha="α", beta="β", gamma="γ", delta="δ", epsilon="ε", zeta="ζ", eta="η", theta="θ", kappa="κ",
    lamda="λ", mu="μ", nu="ν", xi="ξ", pi="π", rho="ρ", sigma="σ", tau="τ", phi="φ", chi="χ",
    psi="ψ", omega="ω", Gamma="Γ", Delta="Δ", Theta="Θ", Lambda="Λ", Xi="Ξ", Pi="Π", Sigma="Σ",
    Phi="Φ", Psi="Ψ", Omega="Ω", **{"lambda": "λ"},
)  # fmt: skip
LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
WORD = re.compile(r"(v(?=[A-Za-z]{2}))?([A-Za-z]+)(\d*)")  # v before the name of a coordinate


def letters(name):
    """A name as pictures show it: "θ₁" for "th1", "vφ" for "vphi", "λ_rod" for "lambda_rod"."""
    words = re.sub(r"_(?=\d*$)", "", name).split("_")
    return "_".join(WORD.sub(_letter, word) if WORD.fullmatch(word) else word for word in words)


def _letter(found):
    base = str(found[2])
    letter = GREEK.get(SHORT.get(base, base), base)
    return f"{found[1] or ''}{letter}{found[3].translate(LOW)}"


def in_full(name):
    """A name whose Greek letter is written in full, as SymPy sets it: "theta1" for "th1"."""
    found = WORD.fullmatch(name)
    if not found or found[2] not in SHORT:
        return name
    return f"{found[1] or ''}{SHORT[found[2]]}{found[3]}"
