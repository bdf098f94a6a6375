"""The whole robot in a window of any shape, until somebody moves the camera, and again when it is asked for."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
import viser

from ..ground.arrays import Array
from .camera import Camera

SAME: Final = (
    1e-3  # of the distance: nearer than this to where the camera was put, nobody has moved it
)
UNDER_WAY: Final = 8  # places that a browser may still tell of while it is already put elsewhere


class Fitting:
    """Puts the camera of each browser where it shows the robot, again when the canvas changes or the robot leaves it.

    A camera that a person has turned, shifted or zoomed is left alone, until its person asks for
    the robot.
    """

    def __init__(self, server: viser.ViserServer, camera: Camera) -> None:
        self.camera = camera  # of who comes now, and of all who did not ask for another
        self._server = server
        self._own: dict[int, Camera] = {}  # by browser
        self._put: dict[int, deque[Array]] = {}  # where it was put of late, by browser
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._gone)

    def _connected(self, client: viser.ClientHandle) -> None:
        self._own[client.client_id] = self.camera
        self._put[client.client_id] = deque([self.camera.position], UNDER_WAY)
        client.camera.on_update(lambda _: self.fit(client))
        self.fit(client)

    def _gone(self, client: viser.ClientHandle) -> None:
        self._put.pop(client.client_id, None)
        self._own.pop(client.client_id, None)

    def show(self, points: Array, client: viser.ClientHandle) -> None:
        """Bring points (k, 3) into the picture of a browser, whoever moved its camera; the direction stays."""
        present = Camera(client.camera.position, client.camera.look_at, 0.0)
        self._own[client.client_id] = present.around(points)
        self._move(client)

    def follow(self, points: Array) -> None:
        """Bring points (k, 3) into all pictures that they have left, but for those whose camera a person moved."""
        before, self.camera = self.camera, self.camera.following(points, 1.0)
        for client in self._server.get_clients().values():
            own = self._own.get(client.client_id)
            if own is not None and not self._moved(client, own):
                own = self.camera if own is before else own
                self._own[client.client_id] = own.following(points, client.camera.aspect)
                self.fit(client)

    def fit(self, client: viser.ClientHandle) -> None:
        """Move the camera to where it belongs, unless a person moved it."""
        own = self._own.get(client.client_id)
        if own is None or self._moved(client, own):
            return
        if not np.allclose(own.seen_from(client.camera.aspect), self._put[client.client_id][-1]):
            self._move(client)

    def _moved(self, client: viser.ClientHandle, own: Camera) -> bool:
        """Whether a person has moved the camera of a browser."""
        here, near = client.camera.position, SAME * np.linalg.norm(own.position - own.look_at)
        return all(np.linalg.norm(here - put) > near for put in self._put.get(client.client_id, ()))

    def _move(self, client: viser.ClientHandle) -> None:
        own = self._own[client.client_id]
        wanted = own.seen_from(client.camera.aspect)
        self._put[client.client_id].append(wanted)
        with client.atomic():
            client.camera.position = wanted
            client.camera.look_at = own.look_at  # viser shifts it along
