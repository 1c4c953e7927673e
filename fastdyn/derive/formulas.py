"""Formulas as a lecturer writes them: x'' in text, dots in LaTeX and MathML, vectors by i, j, k."""

from typing import Any

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.mathml import MathMLPresentationPrinter
from sympy.printing.str import StrPrinter

from fastdyn.words.letters import in_full

UNIT = "ijk"
BOLD = "𝐢𝐣𝐤"  # MathML has no other bold letters


class Formulas:
    """
    Prints the plain symbols of a motion as functions of time and their rates.

    Parameters
    ----------
    motion : Motion
    """

    def __init__(self, motion):
        self._text: dict[sp.Basic, sp.Symbol] = {}
        self._latex: dict[sp.Basic, str] = {}
        self._mathml: dict[sp.Basic, tuple] = {}
        for function, symbol in motion.plain.items():
            order = function.derivative_count if isinstance(function, sp.Derivative) else 0
            name = (function.expr if order else function).func.__name__
            self._text[symbol] = sp.Symbol(name + "'" * order)
            self._mathml[symbol] = name, order
            letter = sp.latex(sp.Symbol(in_full(name)))
            if len(letter) > 1 and letter.isalpha():
                letter = rf"\mathit{{{letter}}}"
            base, low, index = letter.partition("_")
            dotted = base if not order else rf"\{'d' * order}ot{{{base}}}"
            self._latex[symbol] = dotted + low + index

    def text(self, formula):
        """A number or a vector in one line."""
        if isinstance(formula, sp.MatrixBase):
            return _vector([self.text(one) for one in formula], UNIT, "{} {}")
        return _Text({"full_prec": False}).doprint(sp.sympify(formula).xreplace(self._text))

    def latex(self, formula):
        """As `text`, in LaTeX."""
        if isinstance(formula, sp.MatrixBase):
            units = [rf"\mathbf{{{one}}}" for one in UNIT]
            return _vector([self.latex(one) for one in formula], units, r"{}\,{}")
        settings = {"symbol_names": self._latex, "full_prec": False}
        return _Latex(settings).doprint(sp.sympify(formula))

    def mathml(self, formula):
        """As `text`, as elements of MathML."""
        if not isinstance(formula, sp.MatrixBase):
            printer = _MathML({"symbol_names": self._mathml})
            return printer.doprint(sp.sympify(formula))
        terms = ""
        for one, unit in zip(formula.flat(), BOLD, strict=True):
            if one == 0:
                continue
            below = one.could_extract_minus_sign() and not one.is_Add
            size = -one if below else one
            text = "" if size == 1 else self.mathml(size)
            if one.is_Add:
                text = f"<mrow><mo>(</mo>{text}<mo>)</mo></mrow>"
            sign = "<mo>−</mo>" if below else "<mo>+</mo>" if terms else ""
            terms += f"{sign}{text}<mi>{unit}</mi>"
        return f"<mrow>{terms}</mrow>" if terms else "<mn>0</mn>"


def _vector(components, units, together):
    """A sum of multiples of unit vectors."""
    terms = []
    for text, unit in zip(components, units, strict=True):
        if text == "0":
            continue
        if text in ("1", "-1"):
            terms.append(text.replace("1", "") + unit)
            continue
        if "/" in text or _is_sum(text):
            text = f"({text})"
        terms.append(together.format(text, unit))
    return " + ".join(terms).replace("+ -", "- ") if terms else "0"


def _is_sum(text):
    """Whether a text has a sum outside of brackets."""
    depth = 0
    for n, letter in enumerate(text):
        depth += (letter in "({") - (letter in ")}")
        if depth == 0 and n and letter in "+-" and text[n - 1] == " ":
            return True
    return False


class _Latex(LatexPrinter):
    """Short names of Greek letters as letters: th0 is theta0."""

    def _print_Symbol(self, expr, style="plain"):
        named = self._settings["symbol_names"]
        return named.get(expr) or super()._print_Symbol(sp.Symbol(in_full(expr.name)), style)


class _MathML(MathMLPresentationPrinter):
    """Names as `_Latex` has them, with one dot or two for rates."""

    def _print_Symbol(self, sym, style="plain"):
        name, order = self._settings["symbol_names"].get(sym, (sym.name, 0))
        found: Any = super()._print_Symbol(sp.Symbol(in_full(name)), style)
        if not order:
            return found
        letter = found.firstChild if found.nodeName == "msub" else found
        dotted = self.dom.createElement("mover")
        dots = self.dom.createElement("mo")
        dots.appendChild(self.dom.createTextNode("˙¨"[order - 1]))
        if letter is not found:
            found.replaceChild(dotted, letter)
        dotted.appendChild(letter)
        dotted.appendChild(dots)
        return found if letter is not found else dotted


class _Text(StrPrinter):
    """Products by spaces, powers by ², as on a blackboard."""

    _raised = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

    def _print_Mul(self, expr):
        return super()._print_Mul(expr).replace("*", " ")

    def _print_Pow(self, expr, rational=False):
        base, power = expr.as_base_exp()
        if power.is_Integer and power > 0:
            raised = str(power).translate(self._raised)
            if base.is_Function:
                inside = ", ".join(map(self._print, base.args))
                return f"{base.func.__name__}{raised}({inside})"
            return f"{self.parenthesize(base, 100)}{raised}"
        return super()._print_Pow(expr, rational).replace("**", "^")
