"""Viewers in a browser: the protocol of their handles, and how they are opened."""

from __future__ import annotations

from typing import Any, Protocol


class Viewer(Protocol):
    """A viewer in a browser."""

    url: str

    def wait(self) -> None:
        """Waits for Ctrl-C, then ends the viewer."""

    def close(self) -> None:
        """Ends the viewer."""


class LiveViewer(Viewer, Protocol):
    """Viewer of a simulation."""

    def update(self) -> bool:
        """Draws the present state of the simulation.

        It waits while the simulation is paused in the browser, and otherwise keeps the speed that is chosen there.

        Returns
        -------
        bool
            False after `close`.
        """


def opened(kind: str, *arguments: Any, port: int, **options: Any) -> Any:
    """Opens a viewer."""
    if not 1 <= port <= 65535:
        raise ValueError(f"port is {port}: it must be 1 to 65535")
    from .pictures import viewer as tool
    try:
        return getattr(tool, kind)(*arguments, port=port, **options)
    except tool.NoViser as problem:
        raise ImportError(f"the viewer needs viser ({problem.__cause__}): pip install 'nsdae[viewer]'") from None
    except tool.Problem as problem:
        raise ValueError(str(problem)) from None


def shown(viewer: Any) -> None:
    """Opens a browser at a viewer."""
    print(f"{viewer.url} shows it; Ctrl-C ends it", flush=True)
    viewer.open_browser()
