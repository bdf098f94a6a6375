"""Error codes and texts of responses, from exceptions of services."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final

import numpy as np
from hybrid_dynamics_msgs.msg import ErrorCode

from hybrid_dynamics_core.errors import HybridDynamicsError

from ..messages.joint_samples import RejectedError, Rejection, RejectionCode, rejection_of
from ..stream.conditions import ConditionChange
from .context import ServiceContext

OK: Final[int] = ErrorCode.OK

# Fills the response, whose error_code is OK; returns a change of conditions, or None.
Answer = Callable[[ServiceContext, Any, Any], ConditionChange | None]

_CODES: Final = {
    RejectionCode.UNREACHABLE: ErrorCode.OUT_OF_REACH,
    RejectionCode.LIMIT: ErrorCode.LIMIT,
    RejectionCode.SINGULAR: ErrorCode.SINGULAR,
    RejectionCode.INTERNAL: ErrorCode.INTERNAL,
    RejectionCode.NOT_READY: ErrorCode.NOT_READY,
    RejectionCode.REFUSED: ErrorCode.REFUSED,
    RejectionCode.BUSY: ErrorCode.BUSY,
    RejectionCode.TIMEOUT: ErrorCode.TIMEOUT,
}  # all others: BAD_INPUT


def code_of(rejection: Rejection) -> int:
    """The ErrorCode of a rejection."""
    return int(_CODES.get(rejection.code, ErrorCode.BAD_INPUT))


def guarded(
    answer: Answer, context: ServiceContext, request: Any, response: Any
) -> tuple[Any, ConditionChange | None]:
    """Answer a request; exceptions become an error code and text.

    Args:
        answer: the function that fills the response.
        context: the robot and its situation.
        request: request message.
        response: empty response message to fill.

    Returns:
        The response, and a change of conditions or None. After an error the response is empty,
        except `error_code` and `error_text`.
    """
    try:
        # Very large numbers overflow in the model, so the answer is checked instead.
        with np.errstate(all="ignore"):
            return response, answer(context, request, response)
    except RejectedError as error:
        rejection = error.rejection
    except HybridDynamicsError as error:
        rejection = rejection_of(error)
    except Exception as error:  # noqa: BLE001 - a client waits, and the node must go on
        rejection = Rejection(RejectionCode.INTERNAL, f"fault of the node: {error!r}")
    return refused(type(response)(), rejection), None


def refused(response: Any, rejection: Rejection) -> Any:
    """Write a rejection to an empty response, and return it."""
    response.error_code = code_of(rejection)
    response.error_text = rejection.text
    for number in ("residual", "nearest_singularity", "first_bad_time"):
        if hasattr(response, number):
            setattr(response, number, math.nan)
    if hasattr(response, "first_bad"):
        response.first_bad = -1
    return response
