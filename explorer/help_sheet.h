// Sheet of keys and mouse actions.
#pragma once

#include <QAction>
#include <QDialog>
#include <QList>

namespace palpa::explorer {

/// Generated from the window's actions, so it is always up to date. Not modal; deleted when closed.
class HelpSheet : public QDialog {
 public:
  HelpSheet(const QList<QAction*>& actions, QWidget* parent);
};

}  // namespace palpa::explorer
