// Generated for the package @PACKAGE@: what the plugins compute, without ROS.
//
// The numbers come from the C code of the model, once with the drives as independent coordinates
// and once with the joints. Nothing is allocated, and calls are bounded.
#ifndef @PACKAGE@__CORE_HPP_
#define @PACKAGE@__CORE_HPP_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "@PACKAGE@/model.hpp"

namespace @PACKAGE@
{

inline bool is_finite(const Vector & values)
{
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// Close the loops at u from a guess, in pieces that no loop jumps in; the guess is replaced.
inline int follow(const Model & model, const Vector & u, Configuration & guess)
{
  constexpr int most_calls = 256;
  constexpr double shortest = 1.0 / 64.0;
  const Vector still{};
  const Configuration from = guess;
  Configuration s{}, ds{};
  double done = 0.0, piece = 1.0;
  for (int call = 0; call < most_calls; ++call) {
    const bool is_last = done + piece >= 1.0;
    Vector at = u;
    for (std::size_t k = 0; k < N && !is_last; ++k) {
      at[k] = from[k] + (done + piece) * (u[k] - from[k]);
    }
    const int status = model.close(at.data(), still.data(), guess.data(), s.data(), ds.data());
    if (status == OK && is_last) {
      return OK;
    }
    if (status == OK) {
      done += piece;
      piece *= 2.0;
    } else if (!FOLLOWS || piece <= shortest) {
      guess = from;
      return status;
    } else {
      piece *= 0.5;
    }
  }
  guess = from;
  return JUMP;
}

/// Whether two closed configurations are one: at the same u they differ by rounding, or by mode.
inline bool are_same(const Configuration & a, const Configuration & b)
{
  double largest = 0.0;
  for (std::size_t k = 0; k < NS; ++k) {
    largest = std::max(largest, std::abs(a[k] - b[k]));
  }
  return largest < 1e-6;
}

/// Positions, velocities and efforts of one side, and which of them there are.
struct Values
{
  Vector position{}, velocity{}, effort{};
  bool has_position = false, has_velocity = false, has_effort = false;
};

/// The map between drives (actuators) and serial joints, both ways; power is the same on both.
class TransmissionCore
{
public:
  explicit TransmissionCore(bool limits = true) : limits_(limits) {}

  /// What the drives measure, along the joints. Unless the status is OK, `joints` is unchanged.
  int to_joints(const Values & drives, Values & joints)
  {
    Configuration s = measured_, ds{};
    const Vector u = drives.has_position ? drives.position : head(measured_);
    const Vector du = drives.has_velocity ? drives.velocity : Vector{};
    Values result;
    int status = follow(drives_model, u, s);
    if (status == OK) {
      Configuration closed{};
      status = drives_model.close(u.data(), du.data(), s.data(), closed.data(), ds.data());
    }
    if (status == OK && drives.has_effort) {
      status = turned(joints_model, of_joints_model(s), DRIVES, drives.effort, result.effort);
    }
    if (status != OK) {
      return status;
    }
    for (std::size_t k = 0; k < N; ++k) {
      result.position[k] = s[JOINTS[k]];
      result.velocity[k] = ds[JOINTS[k]];
    }
    result.has_position = drives.has_position;
    result.has_velocity = drives.has_velocity;
    result.has_effort = drives.has_effort;
    measured_ = commanded_ = s;
    is_measured_ = true;
    joints = result;
    return OK;
  }

  /// Commands along the joints, for the drives. A command that is not finite is none, and gives
  /// none. Efforts act at what was measured last. Unless the status is OK, `drives` is unchanged.
  int to_drives(const Values & joints, Values & drives)
  {
    const bool moves = joints.has_position && is_finite(joints.position);
    const bool turns = joints.has_velocity && is_finite(joints.velocity);
    const bool pushes = joints.has_effort && is_finite(joints.effort);
    Configuration inner = of_joints_model(commanded_), closed{}, ds{};
    const Vector q = moves ? joints.position : head(of_joints_model(measured_));
    const Vector dq = turns ? joints.velocity : Vector{};
    Values result;
    int status = same_mode(inner);
    if (status == OK) {
      status = follow(joints_model, q, inner);
    }
    if (status == OK) {
      status = joints_model.close(q.data(), dq.data(), inner.data(), closed.data(), ds.data());
    }
    if (status != OK) {
      return status;
    }
    const Configuration s = of_drives_model(inner);
    for (std::size_t k = 0; k < N; ++k) {
      result.position[k] = inner[DRIVES[k]];
      result.velocity[k] = ds[DRIVES[k]];
    }
    if (pushes) {
      const Configuration & at = is_measured_ ? measured_ : s;
      status = turned(drives_model, at, JOINTS, joints.effort, result.effort);
    }
    if (status != OK) {
      return status;
    }
    result.has_position = moves;
    result.has_velocity = turns;
    result.has_effort = pushes;
    if (limits_) {
      limit(result);
    }
    commanded_ = s;
    drives = result;
    return OK;
  }

private:
  static Vector head(const Configuration & s)
  {
    Vector u{};
    std::copy_n(s.begin(), N, u.begin());
    return u;
  }

  /// The same configuration in the order of the other model.
  static Configuration of_joints_model(const Configuration & s)
  {
    Configuration result{};
    for (std::size_t k = 0; k < NS; ++k) {
      result[k] = s[ORDER[k]];
    }
    return result;
  }

  static Configuration of_drives_model(const Configuration & s)
  {
    Configuration result{};
    for (std::size_t k = 0; k < NS; ++k) {
      result[ORDER[k]] = s[k];
    }
    return result;
  }

  /// OK if the joints' model has a configuration in its assembly mode: behind a toggle, where a
  /// drive pulls its rod straight, joints do not say on which side of it the loop is.
  static int same_mode(const Configuration & inner)
  {
    Configuration found = inner;
    const int status = follow(joints_model, head(inner), found);
    return status == OK && !are_same(found, inner) ? JUMP : status;
  }

  /// Efforts along the coordinates of a model that do the work of efforts along other ones.
  static int turned(
    const Model & model, Configuration at, const std::array<std::size_t, N> & places,
    const Vector & efforts, Vector & result)
  {
    Configuration forces{};
    for (std::size_t k = 0; k < N; ++k) {
      forces[places[k]] = efforts[k];
    }
    const Vector u = head(at);
    const Configuration before = at;
    const int status =
      model.generalised_forces(u.data(), forces.data(), at.data(), result.data());
    return status == OK && !are_same(at, before) ? JUMP : status;
  }

  /// Keep commands of the drives within their limits; velocities keep their direction.
  static void limit(Values & drives)
  {
    double share = 1.0;
    for (std::size_t k = 0; k < N; ++k) {
      const double fastest = VELOCITY_LIMITS[k];
      drives.position[k] = std::clamp(drives.position[k], LIMITS[k][0], LIMITS[k][1]);
      drives.effort[k] = std::clamp(drives.effort[k], EFFORT_RANGES[k][0], EFFORT_RANGES[k][1]);
      if (std::abs(drives.velocity[k]) > fastest) {
        share = std::min(share, fastest / std::abs(drives.velocity[k]));
      }
    }
    for (double & velocity : drives.velocity) {
      velocity *= share;
    }
  }

  Configuration measured_ = drives_model.reference();
  Configuration commanded_ = drives_model.reference();
  bool is_measured_ = false;
  bool limits_;
};

/// Efforts for a planned motion, along the joints or along the drives.
class FeedForwardCore
{
public:
  /// limits: whether efforts of the drives stay within their limits; joints have none.
  explicit FeedForwardCore(bool along_joints, bool limits = true)
  : model_(along_joints ? joints_model : drives_model), limits_(limits && !along_joints)
  {
  }

  /// Gravity in base axes [m/s^2].
  void set_gravity(const std::array<double, 3> & gravity) { gravity_ = gravity; }

  /// Unless the status is OK, `efforts` is unchanged.
  int compute(
    const Vector & position, const Vector & velocity, const Vector & acceleration,
    Vector & efforts)
  {
    Configuration s = guess_;
    Vector result{};
    int status = follow(model_, position, s);
    if (status == OK) {
      status = model_.inverse_dynamics(
        position.data(), velocity.data(), acceleration.data(), gravity_.data(), s.data(),
        result.data());
    }
    if (status != OK) {
      return status;
    }
    for (std::size_t k = 0; k < N && limits_; ++k) {
      result[k] = std::clamp(result[k], EFFORT_RANGES[k][0], EFFORT_RANGES[k][1]);
    }
    guess_ = s;
    efforts = result;
    return OK;
  }

private:
  const Model & model_;
  bool limits_;
  Configuration guess_ = model_.reference();
  std::array<double, 3> gravity_ = description_gravity();
};

}  // namespace @PACKAGE@

#endif  // @PACKAGE@__CORE_HPP_
