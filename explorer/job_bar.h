// What is under way, in the status bar, and the button that stops it.
#pragma once

#include <QWidget>

#include "explorer/jobs.h"

class QLabel;

namespace palpa::explorer {

/// Hidden while nothing is under way.
class JobBar : public QWidget {
  Q_OBJECT
 public:
  explicit JobBar(Jobs& jobs);

 Q_SIGNALS:
  /// All that was under way was asked to stop.
  void cancelled();

 private:
  void show_job();

  Jobs& jobs_;
  QLabel* words_;
};

}  // namespace palpa::explorer
