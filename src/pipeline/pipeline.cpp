// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/pipeline.hpp"

#include <atomic>
#include <utility>

#include "graph_updater.hpp"
#include "loop_search.hpp"
#include "scans/scan_odometry.hpp"
#include "scans/scan_preparation.hpp"
#include "threads/message_list.hpp"
#include "threads/stage_thread.hpp"

namespace lidar_mapping::pipeline {

namespace {

// Lengths of the queues. Chosen: scans are large (all take 30 MB), and a few of them are enough to
// balance the stages.
constexpr std::size_t kInputs = 64;
constexpr std::size_t kScans = 4;
constexpr std::size_t kChunks = 8;

/// Path length that the front end repeats to rebuild its local map, m. Chosen: nearly three times
/// local_map_radius. Measured: poses then differ by millimetres from those without a break.
constexpr double kReplayLength = 300.0;
/// Time that preprocessing needs before that.
constexpr Stamp kLeadTime = from_seconds(20.0);

/// Keeps the local frame of a session that is resumed.
preprocessing::PreprocessingConfig with_datum(preprocessing::PreprocessingConfig config,
                                              const session::Session& session) {
  const std::optional<GeodeticDatum> datum = session.datum();
  if (!datum || config.use_datum) return config;
  config.use_datum = true;
  config.datum = {datum->latitude_deg, datum->longitude_deg, datum->altitude_m};
  return config;
}

}  // namespace

class Pipeline::Impl {
 public:
  Impl(const PipelineConfig& config, session::Session session,
       preprocessing::ExtrinsicLookup T_base)
      : threaded_(config.threads != 1),
        graph_updater_(std::move(session), config.back_end, threaded_, feedback_),
        loop_preparation_(config.loop_closing),
        search_(config.loop_closing, graph_updater_.back_end().session(), feedback_),
        resume_point_(resume_point_of(graph_updater_.back_end().session(), kReplayLength,
                                      config.replay_whole)),
        odometry_(
            with_threads(config.front_end, config.threads), config.floor_detection,
            [this](DriveChunk&& chunk) { writing_.push(std::move(chunk)); },
            [this](const std::string& message) { messages_.add(message); }),
        preparation_(
            with_datum(config.preprocessing, graph_updater_.back_end().session()),
            std::move(T_base), pool_,
            [this](PreparedScan&& scan) { matching_.push(std::move(scan)); },
            [this](const std::string& message) { messages_.add(message); }) {
    if (!resume_point_) return;
    key_frames_ = graph_updater_.back_end().session().key_frame_count();
    loops_ = graph_updater_.back_end().session().loops().size();
    search_.restore(graph_updater_.back_end());
    odometry_.resume(*resume_point_);
  }

  std::optional<Stamp> resume_time() const {
    if (!resume_point_ || resume_point_->from_beginning()) return std::nullopt;
    return resume_point_->first.stamp - kLeadTime;
  }

  void add(Input&& input) { preparing_.push(std::move(input)); }

  PipelineReport finish() {
    preparing_.finish();
    preparation_.flush();
    matching_.finish();
    odometry_.flush();
    writing_.finish();
    searching_.finish();
    updating_.finish();
    PipelineReport report;
    const ThreadTime time;
    report.optimization = graph_updater_.finish();
    report.counters = preparation_.counters();
    report.scans_unreadable = preparation_.unreadable();
    report.scans_before_newest = preparation_.before_newest();
    report.progress = progress();
    report.stage_seconds = {{"preprocessing", preparing_.seconds()},
                            {"front end", matching_.seconds()},
                            {"writing of key frames", writing_.seconds()},
                            {"loop closing", searching_.seconds()},
                            {"session and graph", updating_.seconds() + time.seconds()},
                            {"optimisation", graph_updater_.optimization_seconds()}};
    return report;
  }

  Progress progress() const { return {newest_, scans_, key_frames_, loops_}; }

  std::vector<std::string> take_messages() { return messages_.take(); }

  const session::Session& session() { return graph_updater_.back_end().session(); }

 private:
  void match(PreparedScan&& scan) {
    newest_ = scan.synced.scan.stamp;
    odometry_.add(scan);
    pool_.release(std::move(scan.synced.scan.cloud));
    ++scans_;
  }

  void write(DriveChunk&& chunk) {
    if (chunk.key_frame) {
      graph_updater_.back_end().session().clouds().put(chunk.key_frame->index,
                                                       chunk.key_frame->cloud);
      ++key_frames_;
      // Done here, because the loop search has more to do than this stage.
      chunk.prepared = loop_preparation_.prepare(*chunk.key_frame->cloud);
    }
    searching_.push(std::move(chunk));
  }

  void search(DriveChunk&& chunk) {
    search_.process(chunk);
    loops_ += chunk.loops.size();
    updating_.push(std::move(chunk));
  }

  const bool threaded_;
  std::atomic<Stamp> newest_{0};
  std::atomic<std::size_t> scans_{0}, key_frames_{0}, loops_{0};
  MessageList messages_;

  PoseFeedback feedback_;
  GraphUpdater graph_updater_;
  loop_closing::KeyFramePreparation loop_preparation_;
  LoopSearch search_;
  const std::optional<ResumePoint> resume_point_;
  CloudPool pool_;
  ScanOdometry odometry_;
  ScanPreparation preparation_;
  // From the last to the first, so that a stage ends before those that it sends to.
  StageThread<DriveChunk> updating_{kChunks, threaded_,
                                    [this](DriveChunk&& chunk) { graph_updater_.add(chunk); }};
  StageThread<DriveChunk> searching_{kChunks, threaded_,
                                     [this](DriveChunk&& chunk) { search(std::move(chunk)); }};
  StageThread<DriveChunk> writing_{kChunks, threaded_,
                                   [this](DriveChunk&& chunk) { write(std::move(chunk)); }};
  StageThread<PreparedScan> matching_{kScans, threaded_,
                                      [this](PreparedScan&& scan) { match(std::move(scan)); }};
  StageThread<Input> preparing_{kInputs, threaded_,
                                [this](Input&& input) { preparation_.add(std::move(input)); }};
};

Pipeline::Pipeline(const PipelineConfig& config, session::Session session,
                   preprocessing::ExtrinsicLookup T_base)
    : impl_(std::make_unique<Impl>(config, std::move(session), std::move(T_base))) {}
Pipeline::~Pipeline() = default;

std::optional<Stamp> Pipeline::resume_time() const { return impl_->resume_time(); }
void Pipeline::add(Input input) { impl_->add(std::move(input)); }
PipelineReport Pipeline::finish() { return impl_->finish(); }
Progress Pipeline::progress() const { return impl_->progress(); }
std::vector<std::string> Pipeline::take_messages() { return impl_->take_messages(); }
const session::Session& Pipeline::session() const { return impl_->session(); }

}  // namespace lidar_mapping::pipeline
