// Bar for messages above the window's pages, instead of dialogs.
#pragma once

#include <QFrame>

class QLabel;

namespace palpa::explorer {

/// One message at a time. A problem stays until closed or replaced; other messages time out.
class MessageBar : public QFrame {
  Q_OBJECT
 public:
  explicit MessageBar(QWidget* parent = nullptr);
  void say(const QString& words, bool is_problem = false);

 private:
  QLabel* words_;
};

}  // namespace palpa::explorer
