// Sheet of keys and mouse actions, and pages of the documentation.
#pragma once

#include <QAction>
#include <QDialog>
#include <QList>
#include <filesystem>

namespace palpa::explorer {

/// Pages of the documentation, installed or of a checkout; empty: none.
std::filesystem::path pages_folder();

/// Shows pages of the documentation. Not modal; deleted when closed.
class Pages : public QDialog {
 public:
  Pages(const std::filesystem::path& page, QWidget* parent);
};

/// Generated from the window's actions, so it is always up to date. Not modal; deleted when closed.
class HelpSheet : public QDialog {
 public:
  HelpSheet(const QList<QAction*>& actions, QWidget* parent);
};

}  // namespace palpa::explorer
