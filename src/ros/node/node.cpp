// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/ros/node.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <sstream>

#include <CLI/CLI.hpp>
#include <ros/param.h>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/ros/run_state.hpp"
#include "lidar_mapping/ros/warning_limiter.hpp"

namespace lidar_mapping::ros_border {

namespace {

/// Logs each line by itself, so that no log viewer truncates the list.
void log_fatal(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) ROS_FATAL_STREAM(line);
}

/// Key of a kind of message: messages that differ only in their numbers are of one kind.
std::string without_digits(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(),
                            [](unsigned char c) { return std::isdigit(c) != 0; }),
             text.end());
  return text;
}

/// Reads a parameter that roscpp requests from the master at the first logged line, and then
/// caches. Otherwise a master that does not answer would delay the scans at that time.
void prepare_log() {
  bool is_disabled = false;
  ros::param::getCached("/rosout_disable_topics_generation", is_disabled);
}

void run_to_end(const std::function<std::shared_ptr<void>(NodeContext&)>& make) {
  NodeContext context;
  const std::shared_ptr<void> node = make(context);
  if (!node) return;
  // Stops it before the node, which its tasks use, is gone.
  const std::shared_ptr<Worker> worker(&context.worker, [](Worker* stopped) { stopped->stop(); });
  ros::spin();
}

/// The other nodes must not wait for a session that this node will not read.
void end_resuming(const ros::NodeHandle& node) {
  std::string awaited;
  if (!node.getParam(kRunResuming, awaited)) return;
  if (node.resolveName(awaited) == ros::this_node::getName()) node.deleteParam(kRunResuming);
}

/// Keeps the node alive without work, because a restart by roslaunch would fail in the same way.
void idle_with_error(const std::string& problem) {
  ROS_FATAL("this node does nothing: correct the error above, stop the launch and start it again");
  NodeContext context;
  context.diagnostics.set_state(Diagnostics::Level::kError, "did not start: " + problem);
  ros::spin();
}

}  // namespace

NodeContext::NodeContext()
    : worker([limiter = WarningLimiter()](const std::string& channel,
                                          const std::string& what) mutable {
        if (limiter.due(channel + without_digits(what)))
          ROS_WARN_STREAM(channel << ": message left out: " << what);
      }) {}

std::size_t SequenceGaps::check(const std::string& publisher, std::uint32_t sequence) {
  if (sequence == 0) return 0;
  const bool is_continuous = publisher == publisher_ && sequence > newest_;
  const std::size_t missing = is_continuous ? sequence - newest_ - 1 : 0;
  publisher_ = publisher;
  newest_ = sequence;
  return missing;
}

void print_at_exit(const std::string& line) {
  std::printf("%s\n", line.c_str());
  std::fflush(stdout);
}

NodeOptions start_ros(int argc, char** argv, const std::string& name, const std::string& stage) {
  ros::init(argc, argv, name);
  CLI::App app("Topics, services and tf of " + name +
                   " are in doc/reference/nodes.md. Parameters are set as " +
                   "_name:=value; `rosrun lidar_mapping describe_config " + stage +
                   "` prints them.",
               name);
  NodeOptions options;
  app.add_flag("--print-config", options.print_config,
               "Print the configuration in force as YAML and end (asks the ROS master)");
  app.add_flag("--stay-on-error", options.stay_on_error,
               "If the node cannot start, log the reason and wait until it is shut down; for "
               "launch files that would start it again");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    options.exit_status = app.exit(error);
  }
  return options;
}

int run(const std::function<std::shared_ptr<void>(NodeContext&)>& make, bool stay_on_error) {
  // As long as there is a node handle, roscpp and its log keep running.
  const ros::NodeHandle node;
  prepare_log();
  try {
    run_to_end(make);
    return 0;
  } catch (const Error& error) {
    log_fatal(error.what());
    end_resuming(node);
    if (stay_on_error) idle_with_error(error.what());
  } catch (const std::exception& error) {
    log_fatal(std::string("unexpected error: ") + error.what());
    end_resuming(node);
  }
  return 1;
}

}  // namespace lidar_mapping::ros_border
