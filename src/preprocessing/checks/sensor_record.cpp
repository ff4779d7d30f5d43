// SPDX-License-Identifier: BSD-3-Clause
#include "checks/sensor_record.hpp"

#include <algorithm>

#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::preprocessing {

std::string without_leading_slash(const std::string& frame_id) {
  return !frame_id.empty() && frame_id[0] == '/' ? frame_id.substr(1) : frame_id;
}

void TopicStatistics::add(Stamp stamp, const std::string& frame, std::optional<double> delay) {
  if (count == 0) frame_id = frame;
  if (frame != frame_id && other_frame_id.empty()) other_frame_id = frame;
  if (delay && delays.size() < kMaxDelays) delays.push_back(*delay);
  const Stamp step_back = count > 0 ? last_ - stamp : 0;
  if (count > 0 && step_back == 0) ++repeated;
  last_ = stamp;
  if (step_back > 0) ++steps_back;
  longest_step_back = std::max(longest_step_back, step_back);
  if (count++ == 0) {
    first = newest = stamp;
    return;
  }
  if (stamp <= newest) {
    ++backward;
    return;
  }
  if (stamp - newest > longest_gap) {
    longest_gap = stamp - newest;
    gap_begin = newest;
  }
  newest = stamp;
}

double TopicStatistics::rate() const {
  const double seconds = to_seconds(newest - first);
  return seconds > 0.0 ? static_cast<double>(count - 1) / seconds : 0.0;
}

bool TopicStatistics::was_set_back() const {
  // Chosen: two publishers on one topic, or messages out of order, step back with every message.
  constexpr std::size_t kFewSteps = 3;
  // Messages until the time is reached again; chosen: a stray stamp is one alone.
  constexpr std::size_t kMinMessages = 3;
  return steps_back > 0 && steps_back <= kFewSteps && backward > kMinMessages * steps_back &&
         longest_step_back > longest_gap;
}

void add_fault(InputReport& report, const std::string& text, const std::string& remedy) {
  report.diagnostics.push_back({Severity::kFault, text, remedy});
}

void add_warning(InputReport& report, const std::string& text, const std::string& remedy) {
  report.diagnostics.push_back({Severity::kWarning, text, remedy});
}

void check_place(const std::string& frame, const ExtrinsicLookup& lookup, InputReport& report) {
  // m. Chosen: longer than any vehicle; a sensor 0.1 m from base_link is there in millimetres.
  constexpr double kMaxDistance = 100.0;
  const auto T_base_sensor = lookup(frame);
  const double distance = T_base_sensor ? T_base_sensor->translation.norm() : 0.0;
  if (distance < kMaxDistance) return;
  add_fault(
      report,
      formatted("the transform puts '%s' %.0f m from the vehicle's frame", frame.c_str(), distance),
      "transforms are in metres (REP 103); correct its publisher");
}

namespace {

/// The rest of the pipeline has to know where the sensor is.
void check_transform(const std::string& frame, const ExtrinsicLookup& lookup, InputReport& report) {
  const std::string without = report.input == "points"
                                  ? "map_bag uses the frame of the scans as that of the vehicle; "
                                  : "without it the sensor is not used; ";
  if (frame.empty()) {
    add_warning(report, "the messages name no frame",
                without + "the driver must set header.frame_id");
  } else if (!lookup(frame)) {
    add_warning(
        report, "no transform from '" + frame + "' to the vehicle's frame",
        without + "publish it on /tf_static (static_transform_publisher), or set base_frame");
  }
}

void check_frame_names(const TopicStatistics& topic, InputReport& report) {
  if (topic.other_frame_id.empty()) return;
  add_warning(report,
              "the messages name several frames, '" + topic.frame_id + "' and '" +
                  topic.other_frame_id + "'",
              "give each sensor a topic of its own, or each frame a transform");
}

void check_leading_slash(const TopicStatistics& topic, InputReport& report) {
  if (topic.frame() == topic.frame_id) return;
  add_warning(report, "frame '" + topic.frame_id + "' has a leading slash, which tf2 refuses",
              "it is left out here; correct the driver");
}

/// Only the first cause counts: each of them makes stamps that do not increase.
void check_order(const TopicStatistics& topic, InputReport& report) {
  if (topic.newest == 0) {
    add_fault(report, "the stamps are 0",
              "the driver must stamp its messages; map_bag takes the times of their recording");
  } else if (topic.was_set_back()) {
    add_fault(report,
              formatted("the clock of the stamps was set back by %.1f s",
                        to_seconds(topic.longest_step_back)),
              formatted("the %zu messages of that time are left out; synchronise clocks before "
                        "recording, and map the parts before and after by themselves (map_bag "
                        "--start, --duration)",
                        topic.backward));
  } else if (topic.repeated > 0 && topic.repeated == topic.backward) {
    add_fault(report,
              formatted("%zu of %zu messages have the stamp of the one before", topic.repeated,
                        topic.count),
              "they are left out; right if bags overlap or one was named twice, else correct the "
              "driver");
  } else if (topic.backward > 0) {
    add_fault(report, formatted("%zu of %zu stamps do not increase", topic.backward, topic.count),
              "two publishers on one topic, or a recording that starts again; keep one of them");
  }
}

}  // namespace

InputReport check_headers(const std::string& input, const TopicStatistics& topic,
                          const ExtrinsicLookup& lookup) {
  InputReport report{input, "nothing came", {}};
  if (topic.count == 0) return report;
  report.found = formatted("%.1f Hz, frame %s", topic.rate(),
                           topic.frame_id.empty() ? "(none)" : topic.frame_id.c_str());
  check_transform(topic.frame(), lookup, report);
  check_frame_names(topic, report);
  if (input != "points")
    check_place(topic.frame(), lookup, report);  // clouds may be in a moving frame
  check_leading_slash(topic, report);
  check_order(topic, report);
  return report;
}

}  // namespace lidar_mapping::preprocessing
