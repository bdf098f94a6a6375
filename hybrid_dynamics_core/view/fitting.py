"""The whole robot in a window of any shape, until somebody moves the camera."""

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
        self._camera = camera
        self._put: dict[int, Array] = {}  # where it was put, by browser
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._gone)

    def _connected(self, client: viser.ClientHandle) -> None:
        self._put[client.client_id] = self._camera.position
        client.camera.on_update(lambda _: self.fit(client))
        self.fit(client)

    def _gone(self, client: viser.ClientHandle) -> None:
        self._put.pop(client.client_id, None)

    def fit(self, client: viser.ClientHandle) -> None:
        """Move the camera, unless a person did."""
        camera, put = client.camera, self._put.get(client.client_id)
        if put is None or np.linalg.norm(camera.position - put) > SAME * np.linalg.norm(put - self._camera.look_at):
            return
        wanted = self._camera.seen_from(camera.aspect)
        if not np.allclose(wanted, put):
            self._put[client.client_id] = wanted
            with client.atomic():
                camera.position = wanted
                camera.look_at = self._camera.look_at  # viser shifts it along
