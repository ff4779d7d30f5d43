// SPDX-License-Identifier: BSD-3-Clause
#include "session_frame.hpp"

#include <sstream>

#include "lidar_mapping/pipeline/datum.hpp"
#include "lidar_mapping/ros/run_state.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Empty if the datum that is known belongs to another run.
std::optional<GeodeticDatum> session_datum(const std::string& run_id, const ros::NodeHandle& node) {
  std::string text;
  if (!node.getParam(kSessionDatum, text)) return std::nullopt;
  std::istringstream parts(text);
  const auto datum = read_datum(parts);
  std::string run_of_datum;
  std::getline(parts >> std::ws, run_of_datum);
  return run_of_datum == run_id ? datum : std::nullopt;
}

}  // namespace

void store_session_datum(const GeodeticDatum& datum, const std::string& run_id,
                         const ros::NodeHandle& node) {
  node.setParam(kSessionDatum, to_text(datum) + " " + run_id);
}

void SessionFrame::set_drive_datum(const GeodeticDatum& datum) {
  drive_ = datum;
  update();
}

void SessionFrame::begin_run(const std::string& run_id) {
  run_id_ = run_id;
  update();
}

void SessionFrame::update() {
  session_ = session_datum(run_id_, node_);
  T_session_drive_ =
      session_ && drive_ ? pipeline::enu_between(*session_, *drive_) : Pose::Identity();
}

}  // namespace lidar_mapping::ros_border
