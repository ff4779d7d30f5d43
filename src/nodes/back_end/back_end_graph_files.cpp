// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>
#include <system_error>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/home_path.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/pipeline/hdl_dump.hpp"

#include "back_end_node.hpp"
#include "worker_tasks.hpp"

// The services dump_graph and load_graph.
namespace lidar_mapping::ros_border {

namespace {

namespace fs = std::filesystem;
using session::Session;

/// Relative paths start at the working directory of the node.
fs::path absolute_folder(const std::string& path) {
  return fs::absolute(expanded_path(path)).lexically_normal();
}

/// True if Session::open() of a path opens the session in this folder.
bool leads_to(const fs::path& path, const fs::path& folder) {
  std::error_code ignored;
  return fs::equivalent(path, folder, ignored) || fs::equivalent(path / "latest", folder, ignored);
}

/// The current graph, and the session with the clouds.
struct Snapshot {
  pose_graph::PoseGraph graph;
  bool in_enu = false;  ///< its poses lie in East-North-Up
  fs::path session;
};

/// May run during the drive: the session is opened for reading beside the writing worker.
DumpGraph::Response dumped(const Snapshot& snapshot, const std::string& destination) {
  const fs::path directory =
      destination.empty() ? snapshot.session / "hdl_dump" : absolute_folder(destination);
  const Session session = Session::open(snapshot.session, Session::Access::kRead);
  pipeline::write_hdl_dump(session, snapshot.graph, snapshot.in_enu, directory);
  DumpGraph::Response answer;
  answer.success = true;
  answer.directory = directory.string();
  answer.key_frames = static_cast<std::uint32_t>(snapshot.graph.nodes.size());
  answer.edges = static_cast<std::uint32_t>(snapshot.graph.edges.size());
  answer.message = counted(answer.key_frames, "key frame") + " and " +
                   counted(answer.edges, "edge") + " written to " + answer.directory +
                   ", with the poses of the last optimisation";
  return answer;
}

LoadGraph::Response loaded(const Session& session, const fs::path& path) {
  LoadGraph::Response answer;
  answer.success = true;
  answer.session = session.directory().string();
  answer.key_frames = static_cast<std::uint32_t>(session.key_frame_count());
  answer.loops = static_cast<std::uint32_t>(session.loops().size());
  answer.message = counted(answer.key_frames, "key frame") + " and " +
                   counted(answer.loops, "loop") + " loaded from " + path.string() +
                   "; the drive continues in the session " + answer.session +
                   ", in a new segment of the trajectory";
  if (!session.datum() && !session.gnss().empty()) {
    answer.message +=
        "; its GNSS positions have no datum, so that those of a continued drive would lie "
        "elsewhere: leave GNSS out then (use_gnss: false)";
  }
  return answer;
}

}  // namespace

bool BackEndNode::dump_graph(DumpGraph::Request& request, DumpGraph::Response& response) {
  return answered(response, [&] {
    const Snapshot snapshot = result_in(context_.worker, requests_, [this] {
      if (!run_ || run_->session().key_frame_count() == 0) {
        throw InputError("there are no key frames yet; nothing to dump");
      }
      return Snapshot{run_->graph(), run_->in_enu(), run_->session().directory()};
    });
    return dumped(snapshot, request.destination);
  });
}

bool BackEndNode::load_graph(LoadGraph::Request& request, LoadGraph::Response& response) {
  return answered(response, [&] {
    return result_in(context_.worker, requests_,
                     [this, path = request.path] { return load(path); });
  });
}

/// Runs in the worker, so that no drive can begin meanwhile. An empty session that is open stays
/// until the other one is.
LoadGraph::Response BackEndNode::load(const std::string& path) {
  const std::size_t known = run_ ? run_->session().key_frame_count() : 0;
  if (known > 0) {
    throw InputError("a drive is under way (" + counted(known, "key frame") + " in " +
                     run_->session().directory().string() +
                     "); restart back_end_node and load before the first scan");
  }
  continue_session(loaded_session(absolute_folder(path)));
  add_early_measurements();
  return loaded(run_->session(), absolute_folder(path));
}

/// A session is continued in its folder; a dump is converted into a new session.
Session BackEndNode::loaded_session(const fs::path& path) const {
  if (fs::exists(path / "graph.g2o") && fs::is_directory(path / "000000")) {
    return session::create_filled(
        expanded_path(config_.session_directory), std::time(nullptr),
        [&](Session& session) { pipeline::read_hdl_dump(path, session); });
  }
  if (!run_ || !leads_to(path, run_->session().directory())) {
    Session session = Session::open(path, Session::Access::kWrite);
    if (session.key_frame_count() > 0) return session;
  }
  throw InputError("the session " + path.string() + " has no key frames; there is nothing to load");
}

}  // namespace lidar_mapping::ros_border
