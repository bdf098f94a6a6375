// Generated for the package @PACKAGE@: a chainable controller from planned motions to efforts.
#ifndef @PACKAGE@__FEED_FORWARD_CONTROLLER_HPP_
#define @PACKAGE@__FEED_FORWARD_CONTROLLER_HPP_

#include <memory>
#include <string>
#include <vector>

#include "@PACKAGE@/core.hpp"
#include "controller_interface/chainable_controller_interface.hpp"

namespace @PACKAGE@
{

/// Reference interfaces NAME/position, NAME/velocity, NAME/acceleration in; NAME/effort out.
///
/// Parameters: side ("joints" or "drives"), names (those of the side, in its order, where the
/// robot description has other ones), gravity (three numbers), limits (whether efforts of drives
/// are kept within their limits).
class FeedForwardController : public controller_interface::ChainableControllerInterface
{
public:
  controller_interface::CallbackReturn on_init() override;
  controller_interface::InterfaceConfiguration command_interface_configuration() const override;
  controller_interface::InterfaceConfiguration state_interface_configuration() const override;
  controller_interface::CallbackReturn on_configure(
    const rclcpp_lifecycle::State & previous) override;
  controller_interface::CallbackReturn on_activate(
    const rclcpp_lifecycle::State & previous) override;

protected:
  std::vector<hardware_interface::CommandInterface::SharedPtr>
  on_export_reference_interfaces_list() override;
  controller_interface::return_type update_reference_from_subscribers(
    const rclcpp::Time & time, const rclcpp::Duration & period) override;
  controller_interface::return_type update_and_write_commands(
    const rclcpp::Time & time, const rclcpp::Duration & period) override;

private:
  bool read_references(Vector & position, Vector & velocity, Vector & acceleration) const;

  std::vector<std::string> names_;
  std::unique_ptr<FeedForwardCore> core_;
  int status_ = OK;
};

}  // namespace @PACKAGE@

#endif  // @PACKAGE@__FEED_FORWARD_CONTROLLER_HPP_
