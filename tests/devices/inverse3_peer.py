"""An independent Inverse Service on python3-websockets' server: tests that both libraries agree.

Prints its port. Its arm is a spring of 100 N/m without inertia: its position shows the received force, in the service's
axes. Ends with its input.
"""

import asyncio
import http
import json
import sys

try:
    import websockets
except ImportError:
    sys.exit(3)

STIFFNESS_N_PER_M = 100.0
FORCE_LIFETIME_S = 0.05


class Arm:
    force = {"x": 0.0, "y": 0.0, "z": 0.0}
    last_message_s = 0.0

    def told(self):
        zero = {"x": 0.0, "y": 0.0, "z": 0.0}
        if asyncio.get_running_loop().time() - self.last_message_s > FORCE_LIFETIME_S:
            self.force = zero
        place = {axis: force / STIFFNESS_N_PER_M for axis, force in self.force.items()}
        return {
            "session_id": 1,
            "inverse3": [
                {
                    "device_id": "PY01",
                    "state": {
                        "cursor_position": place,
                        "cursor_velocity": zero,
                        "current_cursor_force": self.force,
                    },
                    "status": {"calibrated": True, "power_supply": True},
                }
            ],
            "verse_grip": [],
            # A quarter turn about the axis away from the user.
            "wireless_verse_grip": [
                {
                    "device_id": "PY02",
                    "state": {"orientation": {"w": 0.5**0.5, "x": 0.0, "y": 0.5**0.5, "z": 0.0}, "buttons": {"a": False}},
                    "status": {"connected": True, "awake": True},
                }
            ],
        }

    def obey(self, message):
        self.last_message_s = asyncio.get_running_loop().time()
        for device in message.get("inverse3", []):
            if device["device_id"] == "PY01":
                self.force = device["commands"]["set_cursor_force"]["values"]


async def version(*asked):
    """Answer to GET /version: of (path, headers) before version 14 of the library, of (connection, request) since."""
    answer = '{"ok":true,"data":{"project_version":"3.4.2"}}'
    if asked[0] == "/version":
        return http.HTTPStatus.OK, [("Content-Type", "application/json")], answer.encode()
    if getattr(asked[1], "path", None) == "/version":
        return asked[0].respond(http.HTTPStatus.OK, answer)
    return None


async def main():
    arm = Arm()

    async def serve(socket, *_path):
        await socket.send(json.dumps(arm.told()))
        try:
            async for text in socket:
                arm.obey(json.loads(text))
                await socket.send(json.dumps(arm.told()))
        except websockets.ConnectionClosedError:
            pass  # a client that only polls leaves without a message

    async with websockets.serve(serve, "127.0.0.1", 0, process_request=version, ping_interval=0.05) as server:
        print(server.sockets[0].getsockname()[1], flush=True)
        await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)


asyncio.run(main())
