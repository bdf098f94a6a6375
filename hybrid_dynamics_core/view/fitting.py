"""The whole robot in a window of any shape, until somebody moves the camera, and again when it is asked for."""

from __future__ import annotations

from typing import Final

import numpy as np
import viser

from ..description.model import Array
from .camera import Camera

SAME: Final = 1e-3  # of the distance: nearer than this to where the camera was put, nobody has moved it


class Fitting:
    """Puts the camera of each browser as far away as its canvas needs, and again when the canvas changes."""

    def __init__(self, server: viser.ViserServer, camera: Camera) -> None:
        self.camera = camera  # of who comes now
        self._server = server
        self._own: dict[int, Camera] = {}  # by browser: persons turn them
        self._put: dict[int, Array] = {}  # where it was put, by browser
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._gone)

    def _connected(self, client: viser.ClientHandle) -> None:
        self._own[client.client_id] = self.camera
        self._put[client.client_id] = self.camera.position
        client.camera.on_update(lambda _: self.fit(client))
        self.fit(client)

    def _gone(self, client: viser.ClientHandle) -> None:
        self._put.pop(client.client_id, None)
        self._own.pop(client.client_id, None)

    def show(self, points: Array, client: viser.ClientHandle | None = None) -> None:
        """Bring points (k, 3) into the picture of a browser, or of all where they are not; the direction stays."""
        if client is not None:
            self._aim(client, points)
            return
        if not self.camera.sees(points, 1.0):
            self.camera = self.camera.around(points)
        for each in self._server.get_clients().values():
            if not _present(each).sees(points, each.camera.aspect):
                self._aim(each, points)

    def _aim(self, client: viser.ClientHandle, points: Array) -> None:
        self._own[client.client_id] = _present(client).around(points)
        self._move(client)

    def fit(self, client: viser.ClientHandle) -> None:
        """Move the camera, unless a person did."""
        own, put = self._own.get(client.client_id), self._put.get(client.client_id)
        if own is None or put is None:
            return
        moved = np.linalg.norm(client.camera.position - put) > SAME * np.linalg.norm(put - own.look_at)
        if not moved and not np.allclose(own.seen_from(client.camera.aspect), put):
            self._move(client)

    def _move(self, client: viser.ClientHandle) -> None:
        own = self._own[client.client_id]
        wanted = own.seen_from(client.camera.aspect)
        self._put[client.client_id] = wanted
        with client.atomic():
            client.camera.position = wanted
            client.camera.look_at = own.look_at  # viser shifts it along


def _present(client: viser.ClientHandle) -> Camera:
    """Where a browser looks from, and to."""
    return Camera(client.camera.position, client.camera.look_at, 0.0)
