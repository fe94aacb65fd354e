"""Coroutines over connections that block, as ordinary functions and iterators."""

from __future__ import annotations

import inspect
import re
from collections.abc import AsyncGenerator, Callable, Coroutine, Generator
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from typing_extensions import Concatenate, ParamSpec

    P = ParamSpec("P")

T = TypeVar("T")
R = TypeVar("R")


def run(coroutine: Coroutine[Any, Any, T]) -> T:
    """Returns the value of a coroutine that never suspends: its first step runs it to the end."""
    try:
        coroutine.send(None)
    except StopIteration as done:
        value: T = done.value
        return value
    raise AssertionError("connections that block do not suspend coroutines")


def iterate(items: AsyncGenerator[T, None]) -> Generator[T, None, None]:
    """Yields the items of such a generator and closes it when this one is closed."""
    try:
        while True:
            try:
                item = run(items.__anext__())
            except StopAsyncIteration:
                return
            yield item
    finally:
        run(items.aclose())


def method(
    asynchronous: Callable[Concatenate[Any, P], Coroutine[Any, Any, T]], make: Callable[[T], R]
) -> Callable[Concatenate[Any, P], R]:
    """A blocking version of an asynchronous method of `self._async` that converts the returned value."""

    def call(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return make(run(_begun(call, asynchronous, self, args, kwargs)))

    return _described(call, asynchronous)


def making(asynchronous: Callable[Concatenate[Any, P], T], make: Callable[[T], R]) -> Callable[Concatenate[Any, P], R]:
    """A method that converts the value of a synchronous method of `self._async`."""

    def call(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> R:
        return make(_begun(call, asynchronous, self, args, kwargs))

    return _described(call, asynchronous)


def same(asynchronous: Callable[Concatenate[Any, P], Coroutine[Any, Any, T]]) -> Callable[Concatenate[Any, P], T]:
    """A blocking version of an asynchronous method of `self._async`."""
    return method(asynchronous, lambda value: value)


def iterating(
    asynchronous: Callable[Concatenate[Any, P], AsyncGenerator[T, None]],
) -> Callable[Concatenate[Any, P], Generator[T, None, None]]:
    """A blocking version of an asynchronous generator of `self._async`."""

    def call(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> Generator[T, None, None]:
        return iterate(_begun(call, asynchronous, self, args, kwargs))

    return _described(call, asynchronous)


def _begun(call: Any, asynchronous: Any, self: Any, args: Any, kwargs: Any) -> Any:
    """Calls an asynchronous method; wrong arguments are reported as errors of `call`."""
    try:
        return asynchronous(self._async, *args, **kwargs)
    except TypeError as error:
        message = str(error).replace(f"{asynchronous.__qualname__}()", f"{call.__qualname__}()")
        error.args = (message,)
        raise


C = TypeVar("C", bound=Callable[..., Any])


def _described(call: C, asynchronous: Any) -> C:
    """Copies the name, docstring and signature of the asynchronous method."""
    call.__name__, call.__doc__ = asynchronous.__name__, asynchronous.__doc__
    call.__qualname__ = asynchronous.__qualname__.replace("Async", "")
    signature = inspect.signature(asynchronous)
    gives = str(signature.return_annotation).replace("Async", "")
    coroutine = re.fullmatch(r"Coroutine\[Any, Any, (.*)\]", gives)
    gives = coroutine[1] if coroutine else gives
    call.__signature__ = signature.replace(return_annotation=gives)  # type: ignore[attr-defined]
    return call
