// Keys and mouse actions, on one sheet.
#pragma once

#include <QAction>
#include <QDialog>
#include <QList>

namespace palpa::explorer {

/// Made from the window's own actions, so that it cannot lag behind them. Is not modal; goes when it is closed.
class HelpSheet : public QDialog {
 public:
  HelpSheet(const QList<QAction*>& actions, QWidget* parent);
};

}  // namespace palpa::explorer
