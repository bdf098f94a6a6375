// Generated for the package @PACKAGE@: the plugins load, and the transmission of the example works.
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "gmock/gmock.h"

#include "@PACKAGE@/core.hpp"
#include "hardware_interface/component_parser.hpp"
#include "pluginlib/class_loader.hpp"
#include "transmission_interface/transmission_loader.hpp"
@INCLUDE_CONTROLLER@
namespace
{

std::string text_of(const std::string & path)
{
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace

TEST(Plugins, TransmissionOfTheExampleMapsBothWays)
{
  using transmission_interface::ActuatorHandle;
  using transmission_interface::JointHandle;
  const auto hardware =
    hardware_interface::parse_control_resources_from_urdf(text_of(EXAMPLE_URDF));
  ASSERT_EQ(hardware.size(), 1u);
  ASSERT_EQ(hardware[0].transmissions.size(), 1u);
  const auto & info = hardware[0].transmissions[0];
  pluginlib::ClassLoader<transmission_interface::TransmissionLoader> loader(
    "transmission_interface", "transmission_interface::TransmissionLoader");
  const auto plugin = loader.createUniqueInstance(info.type);
  const auto transmission = plugin->load(info);
  ASSERT_NE(transmission, nullptr);
  std::vector<double> joints(info.joints.size(), 0.0), drives(info.actuators.size(), 0.0);
  std::vector<JointHandle> joint_handles;
  std::vector<ActuatorHandle> drive_handles;
  const auto reference = @PACKAGE@::drives_model.reference();
  for (std::size_t k = 0; k < joints.size(); ++k) {
    drives[k] = reference[k];
    joint_handles.emplace_back(info.joints[k].name, "position", &joints[k]);
    drive_handles.emplace_back(info.actuators[k].name, "position", &drives[k]);
  }
  transmission->configure(joint_handles, drive_handles);
  transmission->actuator_to_joint();
  for (std::size_t k = 0; k < joints.size(); ++k) {
    EXPECT_NEAR(joints[k], reference[@PACKAGE@::JOINTS[k]], 1e-9);
    drives[k] = 0.0;
  }
  transmission->joint_to_actuator();
  for (std::size_t k = 0; k < drives.size(); ++k) {
    EXPECT_NEAR(drives[k], reference[k], 1e-9);
  }
  auto wrong = info;
  wrong.joints.pop_back();
  EXPECT_EQ(plugin->load(wrong), nullptr);
}
@TEST_CONTROLLER@
