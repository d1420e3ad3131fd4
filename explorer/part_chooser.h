// Dialog for files that hold several series or arrays.
#pragma once

#include <QComboBox>
#include <QDialog>
#include <array>
#include <string>
#include <vector>

#include "explorer/opening.h"

class QLineEdit;
class QPushButton;
class QTreeWidget;

namespace palpa::explorer {

/// A list of series, or of HDF5 arrays, of which one is chosen; or of arrays that become fields, where three arrays of numbers
/// can become one vector.
class PartChooser : public QDialog {
  Q_OBJECT
 public:
  /// \param wanted  as before the choice
  PartChooser(const FileContents& contents, const Wanted& wanted, QWidget* parent = nullptr);
  /// With the choice.
  Wanted chosen() const;

 private:
  void list_one(const std::vector<FilePart>& parts, const QStringList& headings);
  void list_arrays();
  void allow();

  FileContents contents_;
  Wanted wanted_;
  QTreeWidget* list_;
  QPushButton* open_ = nullptr;
  QLineEdit* vector_ = nullptr;  ///< name of the vector
  std::array<QComboBox*, 3> components_{};
};

}  // namespace palpa::explorer
