// Generated for the package @PACKAGE@.
#include "@PACKAGE@/feed_forward_controller.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "hardware_interface/types/hardware_interface_type_values.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "rclcpp/logging.hpp"

namespace @PACKAGE@
{
namespace
{

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;

const std::array<const char *, 3> references = {
  hardware_interface::HW_IF_POSITION, hardware_interface::HW_IF_VELOCITY,
  hardware_interface::HW_IF_ACCELERATION};

}  // namespace

CallbackReturn FeedForwardController::on_init()
{
  try {
    const auto gravity = description_gravity();
    auto_declare<std::string>("side", "joints");
    auto_declare<std::vector<std::string>>("names", std::vector<std::string>());
    auto_declare<std::vector<double>>(
      "gravity", std::vector<double>(gravity.begin(), gravity.end()));
    auto_declare<bool>("limits", true);
  } catch (const std::exception & error) {
    RCLCPP_ERROR(get_node()->get_logger(), "%s", error.what());
    return CallbackReturn::ERROR;
  }
  return CallbackReturn::SUCCESS;
}

CallbackReturn FeedForwardController::on_configure(const rclcpp_lifecycle::State &)
{
  const auto logger = get_node()->get_logger();
  const auto side = get_node()->get_parameter("side").as_string();
  if (side != "joints" && side != "drives") {
    RCLCPP_ERROR(logger, "side is '%s'; expected joints or drives", side.c_str());
    return CallbackReturn::FAILURE;
  }
  const bool along_joints = side == "joints";
  const auto & model_names = along_joints ? JOINT_NAMES : DRIVE_NAMES;
  names_ = get_node()->get_parameter("names").as_string_array();
  if (names_.empty()) {
    names_.assign(model_names.begin(), model_names.end());
  }
  if (names_.size() != N) {
    RCLCPP_ERROR(logger, "names has %zu entries; expected %zu", names_.size(), N);
    return CallbackReturn::FAILURE;
  }
  const auto numbers = get_node()->get_parameter("gravity").as_double_array();
  std::array<double, 3> gravity{};
  if (numbers.size() != gravity.size()) {
    RCLCPP_ERROR(logger, "gravity has %zu entries; expected 3", numbers.size());
    return CallbackReturn::FAILURE;
  }
  std::copy(numbers.begin(), numbers.end(), gravity.begin());
  const bool limits = get_node()->get_parameter("limits").as_bool();
  core_ = std::make_unique<FeedForwardCore>(along_joints, limits);
  core_->set_gravity(gravity);
  return CallbackReturn::SUCCESS;
}

CallbackReturn FeedForwardController::on_activate(const rclcpp_lifecycle::State &)
{
  bool done = true;
  for (const auto & reference : ordered_exported_reference_interfaces_) {
    done = reference->set_value(std::numeric_limits<double>::quiet_NaN()) && done;
  }
  status_ = OK;
  return done ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
}

InterfaceConfiguration FeedForwardController::command_interface_configuration() const
{
  InterfaceConfiguration configuration;
  configuration.type = interface_configuration_type::INDIVIDUAL;
  for (const auto & name : names_) {
    configuration.names.push_back(name + "/" + hardware_interface::HW_IF_EFFORT);
  }
  return configuration;
}

InterfaceConfiguration FeedForwardController::state_interface_configuration() const
{
  return {interface_configuration_type::NONE, {}};
}

std::vector<hardware_interface::CommandInterface::SharedPtr>
FeedForwardController::on_export_reference_interfaces_list()
{
  std::vector<hardware_interface::CommandInterface::SharedPtr> result;
  for (const auto & name : names_) {
    const std::string prefix = std::string(get_node()->get_name()) + "/" + name;
    for (const char * kind : references) {
      result.push_back(std::make_shared<hardware_interface::CommandInterface>(prefix, kind));
    }
  }
  return result;
}

/// Alone, the controller has no references: they come from the controller before it.
return_type FeedForwardController::update_reference_from_subscribers(
  const rclcpp::Time &, const rclcpp::Duration &)
{
  return return_type::OK;
}

/// Whether there is a whole reference.
bool FeedForwardController::read_references(
  Vector & position, Vector & velocity, Vector & acceleration) const
{
  const std::array<Vector *, 3> values = {&position, &velocity, &acceleration};
  for (std::size_t k = 0; k < N; ++k) {
    for (std::size_t kind = 0; kind < values.size(); ++kind) {
      const auto & handle = ordered_exported_reference_interfaces_[values.size() * k + kind];
      const auto value = handle->get_optional();
      if (!value.has_value()) {
        return false;
      }
      (*values[kind])[k] = value.value();
    }
  }
  return is_finite(position) && is_finite(velocity) && is_finite(acceleration);
}

/// Without a reference, or where the model has no answer, the last efforts stay.
return_type FeedForwardController::update_and_write_commands(
  const rclcpp::Time &, const rclcpp::Duration &)
{
  Vector position{}, velocity{}, acceleration{}, efforts{};
  if (!read_references(position, velocity, acceleration)) {
    return return_type::OK;
  }
  const int status = core_->compute(position, velocity, acceleration, efforts);
  if (status != OK && status != status_) {
    RCLCPP_ERROR(
      get_node()->get_logger(), "%s; efforts stay as they were", status_text(status));
  }
  status_ = status;
  if (status != OK) {
    return return_type::OK;
  }
  bool done = true;
  for (std::size_t k = 0; k < N; ++k) {
    done = command_interfaces_[k].set_value(efforts[k]) && done;
  }
  return done ? return_type::OK : return_type::ERROR;
}

}  // namespace @PACKAGE@

PLUGINLIB_EXPORT_CLASS(
  @PACKAGE@::FeedForwardController, controller_interface::ChainableControllerInterface)
