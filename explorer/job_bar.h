// The running job, with a button that cancels it.
#pragma once

#include <QFrame>

#include "explorer/jobs.h"

class QLabel;

namespace palpa::explorer {

/// Hidden while no job is running. In the middle of the window for the reading of data; in the status bar for other jobs.
class JobBar : public QFrame {
  Q_OBJECT
 public:
  enum class Shown { other_jobs, reading };
  JobBar(Jobs& jobs, Shown shown);

 Q_SIGNALS:
  /// All running jobs were cancelled.
  void cancelled();

 private:
  void show_job();

  Jobs& jobs_;
  const Shown shown_;
  QLabel* words_;
};

}  // namespace palpa::explorer
