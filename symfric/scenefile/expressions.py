"""Parser of expressions in scene files: text to SymPy by a whitelist over Python's `ast`; nothing is executed.

The value of every constant is computed in floating point as well, so that a number too large is an error before SymPy
evaluates it exactly.
"""

import ast
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

import sympy as sp

from symfric.errors import SceneError
from symfric.fields import LARGEST
from symfric.model.outputs import OF_CONTACTS, friction_force, normal_force
from symfric.model.symbols import nearest, shorten

_NUMBER_BEFORE_WORD = re.compile(
    r"(?<![\w.])(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][+-]?\d+)?(?=(?:and|or|if|else|in|is|not|for)\b)"
)
MAX_CHARACTERS = 10_000
MAX_BRACKETS = 50  # depth of nested brackets
MAX_DEPTH = 60  # depth of the syntax tree, chains of + - * / counted once
MAX_NODES = 3_000
MAX_EXPONENT = 64  # largest exponent of numbers
MAX_POWER = 16  # largest exponent of other expressions, some of which SymPy expands
MAX_BRANCHING = 30  # abs, min, max and pieces of piecewise together: SymPy compares them with one another


FUNCTIONS: dict[
    str, tuple[Callable[..., sp.Expr], Callable[[float], float]]
] = {  # SymPy's function and its value on floats
    "sin": (sp.sin, math.sin),
    "cos": (sp.cos, math.cos),
    "tan": (sp.tan, math.tan),
    "exp": (sp.exp, math.exp),
    "log": (sp.log, math.log),
    "sqrt": (sp.sqrt, math.sqrt),
    "abs": (sp.Abs, abs),
    "sinh": (sp.sinh, math.sinh),
    "cosh": (sp.cosh, math.cosh),
    "tanh": (sp.tanh, math.tanh),
    "asin": (sp.asin, math.asin),
    "acos": (sp.acos, math.acos),
    "atan": (sp.atan, math.atan),
    "sign": (sp.sign, lambda a: float((a > 0) - (a < 0))),
}
EXTREMES: dict[str, tuple[Callable[..., sp.Expr], Callable[..., float]]] = {"min": (sp.Min, min), "max": (sp.Max, max)}
COMPARISONS = {ast.Lt: sp.Lt, ast.LtE: sp.Le, ast.Gt: sp.Gt, ast.GtE: sp.Ge}
# the boundary of a condition is solved for, which SymPy can do for simple functions
IN_COMPARISONS = ("abs", "sin", "cos")
RESERVED = {*FUNCTIONS, *EXTREMES, *OF_CONTACTS, "piecewise", "pi"}

REFUSED = {  # syntax with a cure better than "use numbers, names, ..."
    ast.Attribute: "a dot after a name is not allowed",
    ast.Subscript: "square brackets after a name are not allowed",
    ast.Lambda: "lambda is not allowed",
    ast.NamedExpr: "an assignment is not allowed",
    ast.JoinedStr: "a string is not allowed",
    ast.ListComp: "a comprehension is not allowed",
    ast.GeneratorExp: "a comprehension is not allowed",
    ast.IfExp: "if ... else is not allowed; write piecewise((a, x < 1), b)",
    ast.Tuple: "a comma outside a function's brackets is not allowed",
    ast.Compare: "a comparison is allowed inside piecewise((a, x < 1), b) only",
}


@dataclass(frozen=True)
class _Term:
    """An expression and, if it is constant, its value."""

    expr: sp.Expr
    value: float | None = None


def parse_expression(
    text: str,
    names: Mapping[str, sp.Expr],
    place: str,
    contacts: Sequence[str] = (),
    kinds: Collection[str] = tuple(OF_CONTACTS),
) -> sp.Expr:
    """Parse one expression.

    Parameters
    ----------
    text : str
        Numbers, names, ``+ - * / **``, brackets, the functions of `FUNCTIONS`, ``min``, ``max``, ``pi`` and
        ``piecewise((value, condition), ..., otherwise)``.
    names : mapping of name to Expr
        Meaning of each name; any other is an error.
    place : str
        Place of the text, for messages: ``scene.force[0]``.
    contacts : sequence of str
        Contacts that ``friction_force("name")`` and ``slip("name")`` may ask for.
    kinds : collection of str
        Which of these functions are allowed.

    Returns
    -------
    Expr

    Raises
    ------
    SceneError
        On anything else, with the place and the cure.
    """
    tree = _syntax_tree(text, place)
    try:
        result = _Reader(names, place, tuple(contacts), kinds).term(tree).expr
    except SceneError:
        raise
    except (TypeError, ValueError, ArithmeticError, AttributeError, NotImplementedError, RecursionError):
        # SymPy raises these if an argument of min, max or a comparison may be complex, such as acos(x) for x > 1
        raise SceneError(f"{place}: {shorten(text)!r} is not real or too complicated; simplify it") from None
    if result.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
        raise SceneError(f"{place}: {shorten(text)!r} is not finite; look for a division by zero")
    if result.has(sp.I):
        raise SceneError(f"{place}: {shorten(text)!r} is not real")
    return result


def _syntax_tree(text: str, place: str) -> ast.expr:
    """Return Python's syntax tree of the text; size limits are checked first, because the parser recurses."""
    if len(text) > MAX_CHARACTERS:
        raise SceneError(f"{place}: {len(text)} characters; an expression has at most {MAX_CHARACTERS}")
    text = re.sub(r"\s+", " ", text).strip()
    if not text:
        raise SceneError(f"{place}: the expression is empty")
    depth = 0
    for position, character in enumerate(text):
        depth += (character in "([{") - (character in ")]}")
        if depth > MAX_BRACKETS:
            raise SceneError(f"{place}: more than {MAX_BRACKETS} nested brackets at character {position + 1}")
    if "\\" in text:
        raise SceneError(f"{place}: an expression must not contain a backslash")
    try:
        return ast.parse(_apart(text), mode="eval").body
    except SyntaxError as error:
        at = f" at character {error.offset}" if error.offset else ""
        hint = "check brackets and operators"
        if re.search(r"(?<![=<>!:])=(?!=)", text):
            hint = "write the expression alone, without '='"
        elif re.search(r"(?<![\w.])[\d.]+[A-Za-z_(]|\)\s*[\w(]", text):
            hint = "write * between factors"
        raise SceneError(f"{place}: cannot read {shorten(text)!r}{at}; {hint}") from None
    except (ValueError, RecursionError, MemoryError, OverflowError):
        raise SceneError(f"{place}: {shorten(text, 30)!r} is nested too deeply or too long; simplify it") from None


def _apart(text: str) -> str:
    """Insert a space between a number and a word, which avoids a warning of Python's parser; quoted names stay."""
    parts = re.split(r"('[^']*'|\"[^\"]*\")", text)
    parts[::2] = [_NUMBER_BEFORE_WORD.sub(r"\g<0> ", part) for part in parts[::2]]
    return "".join(parts)


class _Reader:
    """Converts one syntax tree and counts its branches and nesting."""

    def __init__(self, names: Mapping[str, sp.Expr], place: str, contacts: tuple[str, ...], kinds: Collection[str]):
        self.names, self.place, self.contacts, self.kinds = names, place, contacts, kinds
        self.nodes = self.branching = 0
        self.comparing = False

    def refuse(self, message: str) -> NoReturn:
        """Raise `SceneError` with the place of the expression."""
        raise SceneError(f"{self.place}: {message}")

    def term(self, node: ast.AST, depth: int = 0) -> _Term:
        """Return the expression of a node, with its value if all names cancelled."""
        result = self.read(node, depth)
        if result.value is None and result.expr.is_number:
            return _Term(result.expr, self.evaluate(lambda: float(result.expr)))
        return result

    def read(self, node: ast.AST, depth: int) -> _Term:
        """Return the expression of a node."""
        self.nodes += 1
        if self.nodes > MAX_NODES:
            self.refuse(f"more than {MAX_NODES} terms; split the expression")
        if depth > MAX_DEPTH:
            self.refuse(f"nested more than {MAX_DEPTH} deep; write it simpler")
        match node:
            case ast.Constant(value=str(quoted)) if quoted in self.names and not quoted.isidentifier():
                return self.name(quoted)  # a state of a contact whose name is no word, as "left pad.z"
            case ast.Constant():
                return self.constant(node.value)
            case ast.Name():
                return self.name(node.id)
            case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
                inner = self.term(node.operand, depth + 1)
                return inner if isinstance(node.op, ast.UAdd) else self.combine(lambda a: -a, inner)
            case ast.BinOp(op=ast.Add() | ast.Sub()):
                return self.chain(node, (ast.Add, ast.Sub), depth)
            case ast.BinOp(op=ast.Mult() | ast.Div()):
                return self.chain(node, (ast.Mult, ast.Div), depth)
            case ast.BinOp(op=ast.Pow()):
                return self.power(self.term(node.left, depth + 1), self.term(node.right, depth + 1))
            case ast.BinOp(op=ast.BitXor()):
                self.refuse("^ is not a power; write **")
            case ast.Call():
                return self.call(node, depth)
            case ast.Attribute(value=ast.Name(id=contact), attr=own) if f"{contact}.{own}" in self.names:
                return self.name(f"{contact}.{own}")  # a state of a contact, as belt.z
        what = REFUSED.get(type(node), "this is not allowed here")
        cure = "" if ";" in what or "piecewise" in what else "; use numbers, names, + - * / ** and known functions"
        return self.refuse(f"{what}{cure} (at character {getattr(node, 'col_offset', 0) + 1})")

    def constant(self, value: object) -> _Term:
        """Return a number as an Integer or a Float."""
        if isinstance(value, str | bytes):
            self.refuse(f"the string {shorten(repr(value), 30)} is not allowed inside an expression")
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse(f"{shorten(repr(value), 30)} is not a real number")
        if abs(value) > LARGEST:
            self.refuse(f"a number is larger than {LARGEST:g}")
        return _Term(sp.Integer(value) if isinstance(value, int) else sp.Float(value), float(value))

    def name(self, name: str) -> _Term:
        """Return the expression of a name."""
        if name in self.names:
            return _Term(self.names[name])
        if name == "pi":
            return _Term(sp.pi, math.pi)
        if name in RESERVED:
            self.refuse(f"{name} is a function; write {name}(...)")
        return self.refuse(f"unknown name {shorten(name, 40)}{nearest(name, self.names)}")

    def combine(self, operation: Callable[..., Any], *terms: _Term) -> _Term:
        """Apply an operation to expressions and, if all are constants, first to their values."""
        value = self.value_of(operation, terms)
        return _Term(operation(*(t.expr for t in terms)), value)

    def value_of(self, operation: Callable[..., float], terms: Sequence[_Term]) -> float | None:
        """Return the value of an operation on constants; None if one of the terms is not constant."""
        values = [t.value for t in terms if t.value is not None]
        return self.evaluate(operation, *values) if len(values) == len(terms) else None

    def evaluate(self, operation: Callable[..., float], *values: float) -> float:
        """Return the value of an operation on numbers; raise if it is not defined."""
        try:
            value = operation(*values)
        except ZeroDivisionError:
            self.refuse("division by zero")
        except OverflowError:
            self.refuse(f"a number is larger than {LARGEST:g}")
        except (TypeError, ValueError):
            at = f"at {', '.join(format(v, 'g') for v in values)}" if values else "here"
            self.refuse(f"a function has no real value {at}")
        if isinstance(value, complex):
            self.refuse("a root of a negative number is not real")
        if not abs(value) <= LARGEST:
            self.refuse(f"a number is larger than {LARGEST:g}")
        return value

    def chain(self, node: ast.BinOp, kinds: tuple[type, type], depth: int) -> _Term:
        """Read ``a + b - c`` or ``a * b / c`` without recursion along the chain."""
        operands = []
        first: ast.expr = node
        while isinstance(first, ast.BinOp) and isinstance(first.op, kinds):
            operands.append((type(first.op), first.right))
            first = first.left
        terms = [self.term(first, depth + 1)]
        for kind, operand in reversed(operands):
            term = self.term(operand, depth + 1)
            if kind is ast.Sub:
                term = self.combine(lambda a: -a, term)
            elif kind is ast.Div:
                if term.expr.is_zero:
                    self.refuse("division by zero")
                value = None if term.value is None else self.evaluate(lambda a: 1 / a, term.value)
                term = _Term(1 / term.expr, value)
            terms.append(term)
        adding = kinds[0] is ast.Add
        value = self.value_of((lambda *v: sum(v)) if adding else (lambda *v: math.prod(v)), terms)
        return _Term((sp.Add if adding else sp.Mul)(*(t.expr for t in terms)), value)

    def power(self, base: _Term, exponent: _Term) -> _Term:
        """Return a power, with its exponent checked."""
        if self.comparing and exponent.value not in (1, 2, 3, 4):
            self.refuse("a comparison takes the exponents 1 to 4 only")
        if exponent.value is not None:
            if base.value is None and abs(exponent.value) > MAX_POWER:
                self.refuse(f"an exponent is larger than {MAX_POWER}")
            if abs(exponent.value) > MAX_EXPONENT:
                self.refuse(f"an exponent is larger than {MAX_EXPONENT}")
            if (2 * exponent.value).is_integer():  # x**2.0 is the polynomial x**2, x**0.5 the root
                exponent = _Term(sp.Rational(int(2 * exponent.value), 2), exponent.value)
        return self.combine(lambda a, b: a**b, base, exponent)

    def call(self, node: ast.Call, depth: int) -> _Term:
        """Return a call of a known function."""
        if not isinstance(node.func, ast.Name):
            self.refuse("only known functions can be called, such as sin(x)")
        name = node.func.id
        if name not in RESERVED - {"pi"}:
            self.refuse(f"unknown function {shorten(name, 40)}{nearest(name, RESERVED - {'pi'})}")
        if node.keywords or any(isinstance(a, ast.Starred) for a in node.args):
            self.refuse(f"{name}(...) takes plain arguments only")
        if name in OF_CONTACTS:
            return self.of_contact(name, node.args)
        if self.comparing and name not in IN_COMPARISONS:
            self.refuse(f"{name} is not allowed in a comparison; {', '.join(IN_COMPARISONS)} are")
        if name == "piecewise":
            return self.piecewise(node.args, depth)
        if name in EXTREMES:
            if len(node.args) < 2:
                self.refuse(f"{name}(...) takes at least two arguments here")
            self.branch(len(node.args))
            symbolic, numeric = EXTREMES[name]
        else:
            if len(node.args) != 1:
                self.refuse(f"{name}(...) takes one argument, not {len(node.args)}")
            self.branch(name == "abs")
            symbolic, numeric = FUNCTIONS[name]
        terms = [self.term(a, depth + 1) for a in node.args]
        value = self.value_of(numeric, terms)
        return _Term(symbolic(*(t.expr for t in terms)), value)

    def branch(self, count: int) -> None:
        """Count the branches, which SymPy compares pairwise."""
        self.branching += count
        if self.branching > MAX_BRANCHING:
            self.refuse(f"more than {MAX_BRANCHING} of abs, min, max and pieces of piecewise; split the expression")

    def of_contact(self, name: str, arguments: list[ast.expr]) -> _Term:
        """Return the symbol of a contact's friction force or slip."""
        if not self.contacts or name not in self.kinds:
            more = ", or of a contact with a gap" if name == normal_force.__name__ else ""
            self.refuse(f"{name}(...) is allowed in [outputs] only{more}")
        component = self.component(name, arguments)
        contact = arguments[0].value if arguments and isinstance(arguments[0], ast.Constant) else None
        if not isinstance(contact, str):
            self.refuse(f'{name}(...) takes the name of a contact in quotes, as {name}("{self.contacts[0]}")')
        if contact not in self.contacts:
            self.refuse(f"no contact {shorten(contact, 30)!r}{nearest(contact, self.contacts)}")
        return _Term(OF_CONTACTS[name](contact) if component is None else friction_force(contact, component))

    def component(self, name: str, arguments: list[ast.expr]) -> int | None:
        """Return the component of a friction force in the plane, the second argument; None without one."""
        if len(arguments) < 2:
            return None
        given = arguments[1].value if isinstance(arguments[1], ast.Constant) else None
        if name != friction_force.__name__ or len(arguments) > 2:
            self.refuse(f"{name}(...) takes the name of a contact alone")
        if given not in (0, 1) or isinstance(given, bool | float):
            self.refuse(f'{name}("...", k) takes the component k = 0 or 1 of a contact in the plane')
        return 1 if given else 0

    def piecewise(self, arguments: list[ast.expr], depth: int) -> _Term:
        """Return ``piecewise((value, condition), ..., otherwise)``."""
        if len(arguments) < 2 or isinstance(arguments[-1], ast.Tuple):
            self.refuse("piecewise needs pairs and a last value for all other cases: piecewise((a, x < 1), b)")
        self.branch(len(arguments))
        pieces = []
        for pair in arguments[:-1]:
            if not isinstance(pair, ast.Tuple) or len(pair.elts) != 2:
                self.refuse("piecewise takes pairs (value, condition) and a last value: piecewise((a, x < 1), b)")
            value, condition = pair.elts
            pieces.append((self.term(value, depth + 2).expr, self.condition(condition, depth + 2)))
        pieces.append((self.term(arguments[-1], depth + 1).expr, True))
        return _Term(sp.Piecewise(*pieces))

    def condition(self, node: ast.AST, depth: int) -> Any:
        """Return a comparison, or several joined by and / or."""
        if depth > MAX_DEPTH:
            self.refuse(f"nested more than {MAX_DEPTH} deep; write it simpler")
        if isinstance(node, ast.BoolOp):
            self.branch(len(node.values))
            parts = [self.condition(v, depth + 1) for v in node.values]
            return sp.And(*parts) if isinstance(node.op, ast.And) else sp.Or(*parts)
        if not isinstance(node, ast.Compare) or not all(type(op) in COMPARISONS for op in node.ops):
            self.refuse("a condition of piecewise is a comparison with < <= > >=, such as x < 1")
        self.branch(len(node.ops))
        self.comparing = True
        sides = [self.term(n, depth + 1).expr for n in (node.left, *node.comparators)]
        self.comparing = False
        pairs = zip(node.ops, sides[:-1], sides[1:], strict=True)
        return sp.And(*(COMPARISONS[type(op)](a, b) for op, a, b in pairs))
