// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/pipeline/pipeline.hpp"

#include <atomic>
#include <mutex>
#include <utility>

#include "graph_keeper.hpp"
#include "loop_search.hpp"
#include "scan_odometry.hpp"
#include "scan_preparation.hpp"
#include "stage_thread.hpp"

namespace lidar_mapping::pipeline {

namespace {

// Length of the queues. Scans are large, and a few of them are enough to even out the stages.
constexpr std::size_t kInputs = 64;
constexpr std::size_t kScans = 4;
constexpr std::size_t kPieces = 8;

/// What a front end has to see again to know its surroundings as before, m.
constexpr double kStretch = 300.0;
/// What preprocessing has to see before that.
constexpr Stamp kLeadIn = from_seconds(20.0);

/// The local frame of a session stays the same when it is gone on with.
preprocessing::PreprocessingConfig with_datum(preprocessing::PreprocessingConfig config,
                                              const session::Session& session) {
  const std::optional<GeodeticDatum> datum = session.datum();
  if (!datum || config.use_datum) return config;
  config.use_datum = true;
  config.datum = {datum->latitude_deg, datum->longitude_deg, datum->altitude_m};
  return config;
}

/// Beside the front end the other stages need threads, so it gets half of them.
front_end::FrontEndConfig with_threads(front_end::FrontEndConfig config, int threads) {
  config.threads = std::max(1, threads / 2);
  return config;
}

}  // namespace

class Pipeline::Impl {
 public:
  Impl(const PipelineConfig& config, session::Session session,
       preprocessing::ExtrinsicLookup T_base)
      : threaded_(config.threads != 1),
        keeper_(std::move(session), config.back_end, threaded_, feedback_),
        loop_preparation_(config.loop_closing),
        search_(config.loop_closing, keeper_.run().session(), feedback_),
        resume_point_(resume_point_of(keeper_.run().session(), kStretch, config.replay_whole)),
        odometry_(
            with_threads(config.front_end, config.threads), config.floor_detection,
            [this](DrivePiece&& piece) { writing_.push(std::move(piece)); },
            [this](const std::string& notice) { say(notice); }),
        preparation_(
            with_datum(config.preprocessing, keeper_.run().session()), std::move(T_base), spare_,
            [this](PreparedScan&& scan) { matching_.push(std::move(scan)); },
            [this](const std::string& notice) { say(notice); }) {
    if (!resume_point_) return;
    key_frames_ = keeper_.run().session().key_frame_count();
    loops_ = keeper_.run().session().loops().size();
    search_.restore(keeper_.run());
    odometry_.resume(*resume_point_);
  }

  std::optional<Stamp> resumes_from() const {
    if (!resume_point_ || resume_point_->from_beginning()) return std::nullopt;
    return resume_point_->first.stamp - kLeadIn;
  }

  void add(Input&& input) { preparing_.push(std::move(input)); }

  PipelineReport finish() {
    preparing_.finish();
    preparation_.flush();
    matching_.finish();
    odometry_.flush();
    writing_.finish();
    searching_.finish();
    keeping_.finish();
    PipelineReport report;
    const ThreadTime time;
    report.optimization = keeper_.finish();
    report.counters = preparation_.counters();
    report.scans_unreadable = preparation_.unreadable();
    report.progress = progress();
    report.stage_seconds = {{"preprocessing", preparing_.seconds()},
                            {"front end", matching_.seconds()},
                            {"writing of key frames", writing_.seconds()},
                            {"loop closing", searching_.seconds()},
                            {"session and graph", keeping_.seconds() + time.seconds()},
                            {"optimisation", keeper_.solving_seconds()}};
    return report;
  }

  Progress progress() const { return {newest_, scans_, key_frames_, loops_}; }

  std::vector<std::string> take_notices() {
    const std::lock_guard<std::mutex> lock(notices_mutex_);
    return std::exchange(notices_, {});
  }

  const session::Session& session() { return keeper_.run().session(); }

 private:
  void prepare(Input&& input) { preparation_.take(std::move(input)); }

  void match(PreparedScan&& scan) {
    newest_ = scan.synced.scan.stamp;
    odometry_.take(scan);
    spare_.give(std::move(scan.synced.scan.cloud));
    ++scans_;
  }

  void write(DrivePiece&& piece) {
    if (piece.key_frame) {
      keeper_.run().session().clouds().put(piece.key_frame->index, piece.key_frame->cloud);
      ++key_frames_;
      // Here, as the search has more to do than this stage.
      piece.prepared = loop_preparation_.prepare(*piece.key_frame->cloud);
    }
    searching_.push(std::move(piece));
  }

  void search(DrivePiece&& piece) {
    search_.process(piece);
    loops_ += piece.loops.size();
    keeping_.push(std::move(piece));
  }

  void say(const std::string& notice) {
    const std::lock_guard<std::mutex> lock(notices_mutex_);
    notices_.push_back(notice);
  }

  const bool threaded_;
  std::atomic<Stamp> newest_{0};
  std::atomic<std::size_t> scans_{0}, key_frames_{0}, loops_{0};
  std::mutex notices_mutex_;
  std::vector<std::string> notices_;

  PoseFeedback feedback_;
  GraphKeeper keeper_;
  loop_closing::KeyFramePreparation loop_preparation_;
  LoopSearch search_;
  const std::optional<ResumePoint> resume_point_;
  SpareClouds spare_;
  ScanOdometry odometry_;
  ScanPreparation preparation_;
  // From the last to the first: a stage ends before those that it sends to.
  StageThread<DrivePiece> keeping_{kPieces, threaded_,
                                   [this](DrivePiece&& piece) { keeper_.take(piece); }};
  StageThread<DrivePiece> searching_{kPieces, threaded_,
                                     [this](DrivePiece&& piece) { search(std::move(piece)); }};
  StageThread<DrivePiece> writing_{kPieces, threaded_,
                                   [this](DrivePiece&& piece) { write(std::move(piece)); }};
  StageThread<PreparedScan> matching_{kScans, threaded_,
                                      [this](PreparedScan&& scan) { match(std::move(scan)); }};
  StageThread<Input> preparing_{kInputs, threaded_,
                                [this](Input&& input) { prepare(std::move(input)); }};
};

Pipeline::Pipeline(const PipelineConfig& config, session::Session session,
                   preprocessing::ExtrinsicLookup T_base)
    : impl_(std::make_unique<Impl>(config, std::move(session), std::move(T_base))) {}
Pipeline::~Pipeline() = default;

std::optional<Stamp> Pipeline::resumes_from() const { return impl_->resumes_from(); }
void Pipeline::add(Input input) { impl_->add(std::move(input)); }
PipelineReport Pipeline::finish() { return impl_->finish(); }
Progress Pipeline::progress() const { return impl_->progress(); }
std::vector<std::string> Pipeline::take_notices() { return impl_->take_notices(); }
const session::Session& Pipeline::session() const { return impl_->session(); }

}  // namespace lidar_mapping::pipeline
