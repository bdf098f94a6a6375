"""Cameras that show the whole robot in any window, until a user moves them, or on request."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
import viser

from ..ground.arrays import Array
from .camera import Camera

# Largest shift of a camera not moved by a user, as a share of its distance.
NEAR: Final = 1e-3
UNDER_WAY: Final = 8  # earlier positions that a browser may still report after a new one was set


class CameraFit:
    """Sets the camera of each browser so that it shows the robot.

    It does so again when the canvas changes or the robot leaves it. A camera that a user has moved
    is left alone, until the user requests to see the robot.

    Args:
        server: the server of viser.
        camera: initial camera of all browsers.

    Attributes:
        camera: camera of new browsers, and of all without one of their own.
    """

    def __init__(self, server: viser.ViserServer, camera: Camera) -> None:
        self.camera = camera
        self._server = server
        self._cameras: dict[int, Camera] = {}  # by browser
        self._positions: dict[int, deque[Array]] = {}  # recent positions by browser
        server.on_client_connect(self._connected)
        server.on_client_disconnect(self._disconnected)

    def _connected(self, client: viser.ClientHandle) -> None:
        browser = client.client_id
        self._cameras[browser] = self.camera
        self._positions[browser] = deque([self.camera.position], UNDER_WAY)
        client.camera.on_update(lambda _: self.fit(client))
        self.fit(client)

    def _disconnected(self, client: viser.ClientHandle) -> None:
        self._positions.pop(client.client_id, None)
        self._cameras.pop(client.client_id, None)

    def show(self, points: Array, client: viser.ClientHandle) -> None:
        """Show points (k, 3) in a browser, even if its user moved the camera.

        The viewing direction is kept.
        """
        present = Camera(client.camera.position, client.camera.look_at, 0.0)
        self._cameras[client.client_id] = present.around(points)
        self._move(client)

    def follow(self, points: Array) -> None:
        """Show points (k, 3) in all browsers whose picture they have left.

        Cameras moved by users are left alone.
        """
        before = self.camera
        self.camera = before.following(points, 1.0)
        for client in self._server.get_clients().values():
            camera = self._cameras.get(client.client_id)
            if camera is None or self._was_moved(client, camera):
                continue
            if camera is before:
                camera = self.camera
            camera = camera.following(points, client.camera.aspect)
            self._cameras[client.client_id] = camera
            self.fit(client)

    def fit(self, client: viser.ClientHandle) -> None:
        """Move the camera to its place, unless a user moved it."""
        camera = self._cameras.get(client.client_id)
        if camera is None or self._was_moved(client, camera):
            return
        position = camera.position_for(client.camera.aspect)
        last = self._positions[client.client_id][-1]
        if not np.allclose(position, last):
            self._move(client)

    def _was_moved(self, client: viser.ClientHandle, camera: Camera) -> bool:
        """Whether a user has moved the camera of a browser."""
        here = client.camera.position
        distance = np.linalg.norm(camera.position - camera.look_at)
        for position in self._positions.get(client.client_id, ()):
            if np.linalg.norm(here - position) <= NEAR * distance:
                return False
        return True

    def _move(self, client: viser.ClientHandle) -> None:
        camera = self._cameras[client.client_id]
        position = camera.position_for(client.camera.aspect)
        self._positions[client.client_id].append(position)
        with client.atomic():
            client.camera.position = position
            client.camera.look_at = camera.look_at  # viser shifts the position with it
