// Trace of a far hand where its data are, with what the hand felt beside.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/base/new_file.h"
#include "palpa/far/message.h"
#include "palpa/study/recording.h"
#include "palpa/study/run.h"

namespace palpa::app {

/// An ordinary trace of the samples that arrived, and hand.csv (docs/far.md). One thread.
class HandTrace {
 public:
  /// Begins `options.out`/hand-NUMBER. Throws LoadError.
  /// \param limits  of the hand's device, as far as its hello has them
  /// \param number  [1] of the hand
  HandTrace(const RunOptions& options, const LoadedScene& loaded, const DeviceLimits& limits, int number);

  Recorder* recorder() noexcept { return recording_.recorder(); }
  /// Adds what the hand felt when the sample of this tick was sent. Throws LoadError if the disk is full.
  void add(const TickFrame& frame, const ProbeReport& report);
  /// Completes both. Returns why they are incomplete; empty: they are complete.
  std::string finish() noexcept;

 private:
  static detail::Recording begun(const RunOptions& options, const LoadedScene& loaded, const DeviceLimits& limits);
  static RunOptions options_of(RunOptions options, int number);

  const RunOptions options_;
  detail::Recording recording_;
  detail::NewFile felt_;
  std::string rows_;
};

}  // namespace palpa::app
