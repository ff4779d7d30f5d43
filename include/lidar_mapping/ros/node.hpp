// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include <ros/ros.h>

#include "lidar_mapping/config/load.hpp"
#include "lidar_mapping/config/overlay.hpp"
#include "lidar_mapping/ros/diagnostics.hpp"
#include "lidar_mapping/ros/parameters.hpp"
#include "lidar_mapping/ros/worker.hpp"

namespace lidar_mapping::ros_border {

/// Objects that every node has.
struct NodeContext {
  /// Starts the worker, whose errors go into the log. roscpp has to be initialised.
  NodeContext();

  ros::NodeHandle node;                                 ///< the node's namespace
  ros::NodeHandle private_node{"~"};                    ///< the node's private names
  Worker worker;                                        ///< the thread that computes
  Diagnostics diagnostics{node, private_node, worker};  ///< its status on /diagnostics
};

/// Counts messages that were lost in transport, by the numbers that roscpp gives to the messages of
/// a publisher.
class SequenceGaps {
 public:
  /// Returns the number of messages that are missing before this one. A new or restarted publisher
  /// has no gap; neither have sources that do not number their messages (always the same number)
  /// and the repeated messages of a RepeatingPublisher (number 0).
  std::size_t check(const std::string& publisher, std::uint32_t sequence);

 private:
  std::string publisher_;
  std::uint32_t newest_ = 0;
};

/// Length of roscpp's queue. Chosen: callbacks only post to the worker, so it is longer than any
/// burst, and all dropping is done and counted by the worker.
constexpr std::uint32_t kTransportQueue = 100;

/// Capacity of a subscription whose bursts grow with the drive, and of which nothing is said twice.
constexpr int kUnlimited = std::numeric_limits<int>::max();
/// Length of such a queue of roscpp: 0 is no limit, by definition.
constexpr std::uint32_t kUnlimitedQueue = 0;

/// Subscribes `topic`; `arrived` is called for each message in the thread of the callbacks, which
/// it must not hold up. Up to `transport_queue` messages may wait for that.
template <typename Message>
ros::Subscriber subscribe_arrivals(
    NodeContext& context, const std::string& topic, std::uint32_t transport_queue,
    const boost::function<void(const ros::MessageEvent<const Message>&)>& arrived) {
  ros::SubscribeOptions options;
  options.initByFullCallbackType<const ros::MessageEvent<const Message>&>(topic, transport_queue,
                                                                          arrived);
  options.transport_hints = ros::TransportHints().tcpNoDelay();
  return context.node.subscribe(options);
}

/// Subscribes `topic`; `handle` is called for each message in the worker's thread. Up to `capacity`
/// messages may wait there. Messages that are missing by `gaps` count as lost.
template <typename Message>
ros::Subscriber subscribe(NodeContext& context, const std::string& topic, int capacity,
                          std::function<void(const boost::shared_ptr<const Message>&)> handle,
                          const std::shared_ptr<SequenceGaps>& gaps = nullptr) {
  const auto channel = context.worker.add_channel(topic, static_cast<std::size_t>(capacity));
  const boost::function<void(const ros::MessageEvent<const Message>&)> callback =
      [&worker = context.worker, channel, gaps,
       handle = std::move(handle)](const ros::MessageEvent<const Message>& event) {
        const boost::shared_ptr<const Message>& message = event.getConstMessage();
        if constexpr (ros::message_traits::HasHeader<Message>::value) {
          if (gaps) {
            worker.add_lost(channel, gaps->check(event.getPublisherName(), message->header.seq));
          }
        }
        worker.post(channel, [handle, message] { handle(message); });
      };
  const std::uint32_t transport_queue = capacity == kUnlimited ? kUnlimitedQueue : kTransportQueue;
  return subscribe_arrivals<Message>(context, topic, transport_queue, callback);
}

/// The same for a topic of a node of this package, which numbers its messages without gaps.
template <typename Message>
ros::Subscriber subscribe_numbered(
    NodeContext& context, const std::string& topic, int capacity,
    std::function<void(const boost::shared_ptr<const Message>&)> handle) {
  return subscribe<Message>(context, topic, capacity, std::move(handle),
                            std::make_shared<SequenceGaps>());
}

/// Prints a line of a node that is shutting down, when roscpp's log has already ended.
void print_at_exit(const std::string& line);

/// Queue length of a publisher. Chosen: subscribers accept messages at once, so that few ever wait.
constexpr std::uint32_t kPublisherQueue = 100;

/// Calls `make` for the node, which may return null to end at once, spins until the end and stops
/// the worker before the node is destroyed. Errors of configuration and files are logged, a line
/// each; with `stay_on_error` the node then idles, with the error on /diagnostics, until it is shut
/// down. Returns the program's exit status.
int run(const std::function<std::shared_ptr<void>(NodeContext&)>& make, bool stay_on_error);

/// Options on a node's command line beside those of ROS.
struct NodeOptions {
  bool print_config = false;       ///< print the configuration in force and end
  bool stay_on_error = false;      ///< do not end if the node cannot start: it would be restarted
  std::optional<int> exit_status;  ///< set if the program ends at once: help, a wrong option
};

/// Starts roscpp as `name`, which removes ROS's options from the command line, and reads the rest.
/// Needs no ROS master.
NodeOptions start_ros(int argc, char** argv, const std::string& name, const std::string& stage);

/// The body of a node's main. `Node` has a type `Config` with a schema and the constructor
/// Node(const Config&, NodeContext&); its group of parameters has the name of the schema's stage.
/// The node has the program's name.
template <typename Node>
int run_node(int argc, char** argv) {
  using Config = typename Node::Config;
  const std::string& stage = Config::schema().stage();
  const std::string name = std::filesystem::path(argv[0]).filename().string();
  const NodeOptions options = start_ros(argc, argv, name, stage);
  if (options.exit_status) return *options.exit_status;
  const auto make = [&](NodeContext& context) -> std::shared_ptr<void> {
    const auto sources = parameter_sources(context.node, context.private_node, stage);
    const auto config = config::load<Config>(sources);
    for (const std::string& line : config::replaced_values<Config>(sources)) ROS_WARN_STREAM(line);
    const std::string yaml = config::to_yaml(config);
    if (options.print_config) {
      std::fputs(yaml.c_str(), stdout);
      return nullptr;
    }
    publish_effective_configuration(context.node, stage, yaml);
    return std::make_shared<Node>(config, context);
  };
  return run(make, options.stay_on_error);
}

}  // namespace lidar_mapping::ros_border
