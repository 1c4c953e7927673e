"""The nine steps of a derivation, as text, as LaTeX and as HTML."""

import html as web

import sympy as sp

from .algebra import Formula

HEADINGS = (
    "Variables",
    "Positions",
    "Velocities and accelerations",
    "Forces",
    "Laws of motion",
    "Elimination",
    "Constraints",
    "Initial conditions",
    "Solution",
)


class Line:
    """A line of an explanation: words, and formulas as pairs of sides."""

    def __init__(self, words, *sides):
        self.words = words
        self.sides = sides


class Explanation:
    """
    The steps of a derivation: ``print(...)``, or the output of a cell in a notebook.

    Parameters
    ----------
    derivation : Derivation
    """

    def __init__(self, derivation):
        self.formula = derivation.formula
        self.title = derivation.model.title
        self.steps = [
            (heading, step(derivation)) for heading, step in zip(HEADINGS, STEPS, strict=True)
        ]

    def text(self):
        """Plain text, with x'' for accelerations."""
        lines = [self.title]
        for n, (heading, step) in enumerate(self.steps, 1):
            lines += ["", f"{n}. {heading}"]
            for one in step:
                sides = " = ".join(map(self.formula.text, one.sides))
                lines.append("   " + "  ".join(part for part in (one.words, sides) if part))
        return "\n".join(lines)

    def latex(self):
        """LaTeX, for a document."""
        parts = [rf"\section*{{{_escaped(self.title)}}}", r"\begin{enumerate}"]
        for heading, step in self.steps:
            parts.append(rf"\item \textbf{{{heading}.}}")
            for one in step:
                sides = " = ".join(map(self.formula.latex, one.sides))
                parts.append(
                    " ".join(_escaped(one.words).split()) + (rf" \[{sides}\]" if sides else r"\\")
                )
        return "\n".join([*parts, r"\end{enumerate}"])

    def html(self):
        """HTML whose formulas MathJax sets, in notebooks and on pages of Sphinx."""
        parts = [f"<h3>{web.escape(self.title)}</h3>", "<ol>"]
        for heading, step in self.steps:
            parts.append(f"<li><b>{heading}</b>")
            for one in step:
                sides = " = ".join(map(self.formula.latex, one.sides))
                formula = rf"\(\displaystyle {web.escape(sides)}\)" if sides else ""
                # MathJax of Sphinx's pages reads nothing but this class
                parts.append(f'<p>{web.escape(one.words)} <span class="math">{formula}</span></p>')
            parts.append("</li>")
        return "\n".join([*parts, "</ol>"])

    def mathml(self):
        """HTML whose formulas are MathML, which browsers set without a library."""
        parts = ["<ol>"]
        for heading, step in self.steps:
            parts.append(f"<li><b>{web.escape(heading)}</b>")
            for one in step:
                parts.append(f"<div>{web.escape(one.words)}</div>" if one.words else "")
                sides = "<mo>=</mo>".join(map(self.formula.mathml, one.sides))
                if sides:
                    parts.append(f'<div class="formula"><math><mrow>{sides}</mrow></math></div>')
            parts.append("</li>")
        return "\n".join([*parts, "</ol>"])

    __str__ = __repr__ = text
    _repr_html_ = html

    def _repr_latex_(self):
        return self.latex()


def _escaped(words):
    return words.replace("_", r"\_").replace("&", r"\&").replace("%", r"\%")


def _variables(d):
    found = d.model.coordinate_list
    lines = [
        Line(f"coordinate, {one.unit or 1}:", q) for one, q in zip(found, d.motion.q, strict=True)
    ]
    lines += [
        Line(f"{one.meaning}, {one.unit}:", one.symbol, sp.Float(one.default, 15))
        for one in d.model.numbers
    ]
    for one in d.model.drivers:
        given = [sp.Symbol(name, real=True) for name in one.gives]
        lines += [Line(f"given by {one.name}(t, w):", symbol) for symbol in given]
    lines += [Line("sense of a slip, 1 or -1:", symbol) for symbol in d.motion.senses]
    return lines


def _positions(d):
    return [Line(f"{one.name} is at", one.r) for one in d.bodies]


def _rates(d):
    lines = []
    for one in d.bodies:
        lines.append(Line(f"{one.name}, velocity:", one.v))
        lines.append(Line(f"{one.name}, acceleration:", one.acceleration))
        if one.body.rigid:
            lines.append(Line(f"{one.name}, angular velocity:", one.omega))
            lines.append(Line(f"{one.name}, angular momentum:", one.momentum))
    return lines


def _forces(d):
    lines = []
    for one in d.bodies:
        force, torque = one.resultant()
        lines.append(Line(f"on {one.name}:", force))
        if one.body.rigid:
            lines.append(Line(f"on {one.name}, torque about its centre:", torque))
    names = ", ".join(map(d.formula.text, d.motion.reactions))
    lines += [Line(f"reactions of unknown size: {names}")] if names else []
    for one in d.model.contacts:
        size = one.names[0]
        reaction = f"|{one.name}|"
        most = d.formula.text(d.plain(one.static))
        if one.name in d.at_rest:
            lines.append(
                Line(f"{size} holds the body: it rests while |{size}| <= ({most}) {reaction}")
            )
            continue
        slipping = d.formula.text(d.plain(one.friction))
        lines.append(Line(
            f"{size} is ({slipping}) {reaction} against the slip; at rest it is what holds the "
            f"body, at most ({most}) {reaction}"
        ))  # fmt: skip
    return lines


def _laws(d):
    lines = []
    if d.law == "lagrange":
        lines = [Line("kinetic energy:", d.kinetic), Line("potential energy:", d.potential)]
    return lines + [Line(f"{law.name}:", law.left, law.right) for law in d.laws.written]


def _elimination(d):
    if d.law == "lagrange":
        return [Line("Reactions that do no work do not appear.")]
    equations = list(zip(d.K * sp.Matrix(d.unknowns), d.r, strict=True))
    equations = equations[: len(equations) - len(d.held)] if d.held else equations
    return [
        Line("Components along what can move, and along the reactions, are enough:"),
        *(Line("", left, right) for left, right in equations),
    ]


def _constraints(d):
    if not d.held:
        n = len(d.unknowns)
        return [Line(f"None: there are {n} equations for {n} unknowns.")]
    lines = []
    for one in d.held:
        of = "velocities" if one.position is None else "positions"
        first = one.velocity if one.position is None else one.position
        lines.append(Line(f"{one.name}, of {of}:", first, sp.S.Zero))
        left = (one.row * sp.Matrix(d.motion.a))[0]
        lines.append(Line("differentiated until it is of accelerations:", left, one.b))
    return lines


def _start(d):
    q = d.motion.q
    v = d.motion.v
    given = d.model.given
    tied = {
        s for one in d.held if one.position is not None for s in one.position.free_symbols & {*q}
    }
    tied |= {s for one in d.held for s in one.velocity.free_symbols & {*v}}
    found = [s for s in (*q, *v) if s in tied and str(s) not in given]
    lines = [
        Line("", symbol, one)
        for symbol, one in zip((*q, *v), d.start.expressions, strict=True)
        if symbol not in found
    ]
    names = ", ".join(map(d.formula.text, found))
    return [*lines, Line(f"found from the constraints: {names}")] if names else lines


def _solution(d):
    lines = []
    for step in d.steps:
        if isinstance(step, Formula):
            lines.append(Line("", step.unknown, step.value))
            continue
        names = ", ".join(map(d.formula.text, step.unknowns))
        lines.append(Line(f"solved together at each evaluation, {names}:"))
        left = step.matrix * sp.Matrix(step.unknowns)
        lines += [Line("", a, b) for a, b in zip(left, step.right, strict=True)]
    names = ", ".join(str(s) for s in (*d.motion.q, *d.motion.v))
    rates = ", ".join(d.formula.text(s) for s in (*d.motion.v, *d.motion.a))
    return [*lines, Line(f"As equations of first order: w = [{names}], w' = [{rates}].")]


STEPS = (
    _variables, _positions, _rates, _forces, _laws, _elimination, _constraints, _start, _solution,
)  # fmt: skip
