#pragma once

#include <string>

namespace lidar_mapping::test {

/// True if the topic has one publisher and this has a connection to every node that subscribes, as
/// the publisher itself says: on a busy machine these come long after the master knows both, and
/// what is sent before is lost. A link to a node of that name that was killed does not count.
bool is_connected(const std::string& topic);

/// Process id of a node, as it says itself; 0 if it does not answer.
int process_of(const std::string& node);

}  // namespace lidar_mapping::test
