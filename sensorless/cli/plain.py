"""Commands whose help shows what a user types: a flag takes no value, so it shows no ``<bool>``."""

from typing import Any, TypeVar

from typer import BadParameter
from typer.core import TyperCommand, TyperGroup

from sensorless.cli.apart import keep_apart, keep_motor_files
from sensorless.errors import UserError, shown

P = TypeVar("P")


def without_types(params: list[P]) -> list[P]:
    """Return the options themselves, with the type of every flag left out of their help."""
    for param in params:
        given: Any = param
        if getattr(given, "is_flag", False) and given.metavar is None:
            given.metavar = ""
    return params


def _single(param: Any) -> bool:
    return param.param_type_name == "option" and not (param.multiple or param.is_flag)


class Command(TyperCommand):
    """A command with plain flags, which never writes over its own input, or over a motor file."""

    def get_params(self, ctx: Any) -> Any:
        """Options and arguments, ``--help`` among them."""
        return without_types(super().get_params(ctx))

    def parse_args(self, ctx: Any, args: list[str]) -> Any:
        """Read the words; a value of the wrong type is named, whatever the library says of it.

        An option with one value may stand once: the library would take the last one in silence.
        """
        _, _, given = self.make_parser(ctx).parse_args(list(args))
        for option in {p.name: p for p in given if _single(p)}.values():
            if given.count(option) > 1:
                raise UserError(f"{option.opts[0]}: given twice; give it once")
        try:
            return super().parse_args(ctx, args)
        except BadParameter as error:
            cause: Any = error.__cause__  # of pydantic, whose message leaves out the value
            found = cause.errors() if hasattr(cause, "errors") else ()
            value = shown(found[0]["input"]) if found else ""
            if value not in error.message:
                error.message = f"{value}: {error.message}"
            raise

    def invoke(self, ctx: Any) -> Any:
        """Run the command, unless it would lose a file."""
        params: list[Any] = list(self.params)
        names = {p.name: p.opts[0] for p in params}
        names |= {p.name: p.metavar or p.name.upper() for p in params if names[p.name][0] != "-"}
        keep_apart(ctx.params, names)
        keep_motor_files(ctx.params, names)
        return super().invoke(ctx)


class Group(TyperGroup):
    """A group of commands with plain flags; a name may be two words, like ``tune gains``."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Command of the first two words, or else of the first."""
        two = " ".join(args[:2])
        if two in self.commands:
            return two, self.commands[two], args[2:]
        return super().resolve_command(ctx, args)

    def get_params(self, ctx: Any) -> Any:
        """Options, ``--help`` among them."""
        return without_types(super().get_params(ctx))
