// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <exception>
#include <future>
#include <memory>
#include <string>
#include <utility>

#include <ros/publisher.h>
#include <ros/single_subscriber_publisher.h>
#include <ros/wall_timer.h>

#include "lidar_mapping/ros/node.hpp"

// What services, timers and new subscribers ask of a worker. All of them come in other threads.
namespace lidar_mapping::ros_border {

/// Lets `worker` call `make`, waits, and returns what that returns or throws what it throws. Throws
/// std::future_error if the worker ends before.
template <typename Make>
auto result_in(Worker& worker, Worker::ChannelId channel, Make make) {
  auto task = std::make_shared<std::packaged_task<decltype(make())()>>(std::move(make));
  auto result = task->get_future();
  worker.post(channel, [task = std::move(task)] { (*task)(); });
  return result.get();
}

/// Sets the response of a service to what `make` returns. If that throws, the message of the
/// response says why. Returns true, as roscpp wants it of a service that has answered.
template <typename Response, typename Make>
bool answered(Response& response, const Make& make) {
  try {
    response = make();
  } catch (const std::future_error&) {
    response.message = "the node is ending";
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

/// Lets the worker do `task` at intervals of the wall clock, because simulated time may stand
/// still. The task has a channel of its own, in which it waits at most once: a worker that is busy
/// for long loses nothing by it.
inline ros::WallTimer do_at_intervals(NodeContext& context, const std::string& channel_name,
                                      double seconds, Worker::Task task) {
  const auto channel = context.worker.add_channel(channel_name, 1);
  const auto waits = std::make_shared<std::atomic<bool>>(false);
  const auto post = [&worker = context.worker, channel, waits,
                     task = std::move(task)](const ros::WallTimerEvent&) {
    if (waits->exchange(true)) return;
    worker.post(channel, [waits, task] {
      *waits = false;
      task();
    });
  };
  return context.node.createWallTimer(ros::WallDuration(seconds), post);
}

/// Advertises a topic. The worker does `greet` for each new subscriber.
template <typename Message>
ros::Publisher advertise(NodeContext& context, const std::string& topic, std::uint32_t queue_size,
                         Worker::ChannelId channel, Worker::Task greet, bool latched = false) {
  const auto post = [&worker = context.worker, channel, greet = std::move(greet)](
                        const ros::SingleSubscriberPublisher&) { worker.post(channel, greet); };
  return context.node.advertise<Message>(topic, queue_size, post, ros::SubscriberStatusCallback(),
                                         ros::VoidConstPtr(), latched);
}

}  // namespace lidar_mapping::ros_border
