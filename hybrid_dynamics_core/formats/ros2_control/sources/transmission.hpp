// Generated for the package @PACKAGE@: the transmission between drives and serial joints.
#ifndef @PACKAGE@__TRANSMISSION_HPP_
#define @PACKAGE@__TRANSMISSION_HPP_

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "@PACKAGE@/core.hpp"
#include "hardware_interface/hardware_info.hpp"
#include "transmission_interface/transmission.hpp"
#include "transmission_interface/transmission_loader.hpp"

namespace @PACKAGE@
{

/// Names of one side in the robot description, in the order of the model, and reductions.
struct SideNames
{
  std::array<std::string, N> names;
  Vector reductions;
};

class Transmission : public transmission_interface::Transmission
{
public:
  Transmission(const SideNames & joints, const SideNames & actuators, bool limits);

  /// Each interface that one joint (actuator) has, all have.
  void configure(
    const std::vector<transmission_interface::JointHandle> & joints,
    const std::vector<transmission_interface::ActuatorHandle> & actuators) override;

  void actuator_to_joint() override;
  void joint_to_actuator() override;

  std::size_t num_actuators() const override { return N; }
  std::size_t num_joints() const override { return N; }

  /// The status of the last call; while it is not OK, values stay as they were.
  int status() const { return status_; }

private:
  template <typename HandleT>
  struct Handles
  {
    std::vector<HandleT> position, velocity, effort;
  };

  void report(int status);

  SideNames joint_names_, actuator_names_;
  Handles<transmission_interface::JointHandle> joints_;
  Handles<transmission_interface::ActuatorHandle> actuators_;
  TransmissionCore core_;
  int status_ = OK;
};

class TransmissionLoader : public transmission_interface::TransmissionLoader
{
public:
  std::shared_ptr<transmission_interface::Transmission> load(
    const hardware_interface::TransmissionInfo & info) override;
};

}  // namespace @PACKAGE@

#endif  // @PACKAGE@__TRANSMISSION_HPP_
