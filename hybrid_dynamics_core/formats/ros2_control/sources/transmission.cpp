// Generated for the package @PACKAGE@.
#include "@PACKAGE@/transmission.hpp"

#include <algorithm>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/logging.hpp"
#include "transmission_interface/exception.hpp"

namespace @PACKAGE@
{
namespace
{

const char * const logger_name = "@PACKAGE@";

/// The handles of one interface, in the order of the model; none if no name has it.
template <typename HandleT>
std::vector<HandleT> ordered(
  const std::vector<HandleT> & handles, const SideNames & side, const std::string & interface)
{
  std::vector<HandleT> result;
  std::string missing;
  for (const auto & name : side.names) {
    const auto found = std::find_if(handles.begin(), handles.end(), [&](const HandleT & handle) {
      return handle && handle.get_prefix_name() == name &&
             handle.get_interface_name() == interface;
    });
    if (found == handles.end()) {
      missing = name;
    } else {
      result.push_back(*found);
    }
  }
  if (!result.empty() && result.size() != N) {
    throw transmission_interface::Exception(
      "'" + missing + "' has no interface '" + interface + "', which others have");
  }
  return result;
}

template <typename HandlesT>
bool has_any(const HandlesT & handles)
{
  return !handles.position.empty() || !handles.velocity.empty() || !handles.effort.empty();
}

/// Values of handles over their reductions: motions are divided, efforts multiplied.
template <typename HandlesT>
Values read(const HandlesT & handles, const Vector & reductions)
{
  Values values;
  values.has_position = !handles.position.empty();
  values.has_velocity = !handles.velocity.empty();
  values.has_effort = !handles.effort.empty();
  for (std::size_t k = 0; k < N; ++k) {
    if (values.has_position) {
      values.position[k] = handles.position[k].get_value() / reductions[k];
    }
    if (values.has_velocity) {
      values.velocity[k] = handles.velocity[k].get_value() / reductions[k];
    }
    if (values.has_effort) {
      values.effort[k] = handles.effort[k].get_value() * reductions[k];
    }
  }
  return values;
}

template <typename HandlesT>
void write(const Values & values, const Vector & reductions, HandlesT & handles)
{
  for (std::size_t k = 0; k < N; ++k) {
    if (values.has_position && !handles.position.empty()) {
      handles.position[k].set_value(values.position[k] * reductions[k]);
    }
    if (values.has_velocity && !handles.velocity.empty()) {
      handles.velocity[k].set_value(values.velocity[k] * reductions[k]);
    }
    if (values.has_effort && !handles.effort.empty()) {
      handles.effort[k].set_value(values.effort[k] / reductions[k]);
    }
  }
}

/// The names of one side by role, or by name where no role is given.
template <typename InfoT>
SideNames side_of(
  const std::vector<InfoT> & infos, const std::array<const char *, N> & expected,
  const std::string & kind)
{
  SideNames side;
  if (infos.size() != N) {
    throw transmission_interface::Exception(
      "there are " + std::to_string(infos.size()) + " " + kind + "s; expected " +
      std::to_string(N));
  }
  for (std::size_t k = 0; k < N; ++k) {
    const std::string wanted = expected[k];
    const auto found = std::find_if(infos.begin(), infos.end(), [&](const InfoT & info) {
      return (info.role.empty() ? info.name : info.role) == wanted;
    });
    if (found == infos.end()) {
      throw transmission_interface::Exception("no " + kind + " has the name or role '" + wanted + "'");
    }
    if (found->mechanical_reduction == 0.0) {
      throw transmission_interface::Exception("the reduction of '" + found->name + "' is zero");
    }
    if (kind == "joint" && found->mechanical_reduction != 1.0) {
      throw transmission_interface::Exception(
        "'" + found->name + "' has a reduction; only actuators have one");
    }
    if (found->offset != 0.0) {
      throw transmission_interface::Exception(
        "'" + found->name + "' has an offset; zeros are those of the robot's description");
    }
    side.names[k] = found->name;
    side.reductions[k] = found->mechanical_reduction;
  }
  return side;
}

bool wants_limits(const hardware_interface::TransmissionInfo & info)
{
  const auto found = info.parameters.find("limits");
  if (found == info.parameters.end() || found->second == "true") {
    return true;
  }
  if (found->second == "false") {
    return false;
  }
  throw transmission_interface::Exception(
    "limits is '" + found->second + "'; expected true or false");
}

}  // namespace

Transmission::Transmission(
  const SideNames & joints, const SideNames & actuators, bool limits)
: joint_names_(joints), actuator_names_(actuators), core_(limits)
{
}

void Transmission::configure(
  const std::vector<transmission_interface::JointHandle> & joints,
  const std::vector<transmission_interface::ActuatorHandle> & actuators)
{
  using hardware_interface::HW_IF_EFFORT;
  using hardware_interface::HW_IF_POSITION;
  using hardware_interface::HW_IF_VELOCITY;
  joints_.position = ordered(joints, joint_names_, HW_IF_POSITION);
  joints_.velocity = ordered(joints, joint_names_, HW_IF_VELOCITY);
  joints_.effort = ordered(joints, joint_names_, HW_IF_EFFORT);
  actuators_.position = ordered(actuators, actuator_names_, HW_IF_POSITION);
  actuators_.velocity = ordered(actuators, actuator_names_, HW_IF_VELOCITY);
  actuators_.effort = ordered(actuators, actuator_names_, HW_IF_EFFORT);
  if (!has_any(joints_) || !has_any(actuators_)) {
    throw transmission_interface::Exception(
      "joints and actuators need handles of position, velocity or effort");
  }
}

void Transmission::actuator_to_joint()
{
  Values result;
  const int status = core_.to_joints(read(actuators_, actuator_names_.reductions), result);
  if (status == OK) {
    write(result, joint_names_.reductions, joints_);
  }
  report(status);
}

void Transmission::joint_to_actuator()
{
  Values result;
  const int status = core_.to_drives(read(joints_, joint_names_.reductions), result);
  if (status == OK) {
    write(result, actuator_names_.reductions, actuators_);
  }
  report(status);
}

/// Log a status once, when it changes.
void Transmission::report(int status)
{
  if (status != status_ && status != OK) {
    RCLCPP_ERROR(
      rclcpp::get_logger(logger_name), "transmission: %s; values stay as they were",
      status_text(status));
  }
  status_ = status;
}

std::shared_ptr<transmission_interface::Transmission> TransmissionLoader::load(
  const hardware_interface::TransmissionInfo & info)
{
  try {
    const auto joints = side_of(info.joints, JOINT_NAMES, "joint");
    const auto actuators = side_of(info.actuators, DRIVE_NAMES, "actuator");
    return std::make_shared<Transmission>(joints, actuators, wants_limits(info));
  } catch (const std::exception & error) {
    RCLCPP_ERROR(
      rclcpp::get_logger(logger_name), "transmission '%s': %s", info.name.c_str(), error.what());
    return nullptr;
  }
}

}  // namespace @PACKAGE@

PLUGINLIB_EXPORT_CLASS(@PACKAGE@::TransmissionLoader, transmission_interface::TransmissionLoader)
