// Status-bar entry of the running job, with a button that cancels it.
#pragma once

#include <QWidget>

#include "explorer/jobs.h"

class QLabel;

namespace palpa::explorer {

/// Hidden while no job is running.
class JobBar : public QWidget {
  Q_OBJECT
 public:
  explicit JobBar(Jobs& jobs);

 Q_SIGNALS:
  /// All running jobs were cancelled.
  void cancelled();

 private:
  void show_job();

  Jobs& jobs_;
  QLabel* words_;
};

}  // namespace palpa::explorer
