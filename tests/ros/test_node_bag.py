"""The running node and the same messages from a bag: equal to the last bit."""

import numpy as np
import pytest
from sensor_msgs.msg import JointState

ACTIVE = ["q1", "q12", "q22", "q4"]


def test_a_bag_has_what_the_running_node_answers(client, tmp_path):
    pytest.importorskip("rosbags")
    from hybrid_dynamics_ros.bags.analysis.collect import collect
    from tests.bags.messages import bag, joint_state

    first = client.new_stamp(10.0)
    rng = np.random.default_rng(2)
    pairs, answers = [], []
    for k in range(30):
        position, velocity = (
            np.add([0.1, 0.1, 0.15, 0.2], rng.normal(0, 1e-3, 4)),
            rng.normal(0, 0.01, 4),
        )
        stamp = first if k == 0 else client.new_stamp(0.01)
        message = JointState(name=ACTIVE, position=position.tolist(), velocity=velocity.tolist())
        client.publish("active_joint_states", message, stamp)
        answers.append((client.wait_for("joint_states", stamp), k))
        pairs.append((stamp, joint_state(stamp, ACTIVE, position, velocity)))
    track = collect(bag(tmp_path / "in", pairs), "forging_chu2020")
    for answer, k in answers:
        assert np.array_equal(answer.position, track.state.s[k])
        assert np.array_equal(answer.velocity, track.state.ds[k])
        efforts = np.array(answer.effort)[:4]
        assert (
            np.array_equal(efforts, track.efforts[k])
            if len(efforts)
            else np.isnan(track.efforts[k]).all()
        )
    assert np.isfinite(track.efforts[-20:]).all()
