// Slice through the data perpendicular to an axis of the world.
#pragma once

#include <QImage>
#include <QTimer>
#include <QWidget>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "explorer/label_colors.h"
#include "explorer/paint.h"
#include "explorer/slice_tiles.h"
#include "palpa/data/field.h"
#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// Display settings shared by all slices of a scene: field and colour mapping.
struct SliceLook {
  FieldPtr field;                       ///< scalar or vector (shown by magnitude), hand frame; null: empty slice
  std::string name, unit;               ///< of the field
  QString words{};                      ///< name and unit for the user: "|velocity| / m/s", "value, no unit in the file"
  std::vector<SeenLabel> labels{};      ///< of a label map, shown by their colours; empty: other fields
  std::optional<int> octave{};          ///< of a volume larger than memory: the one of `field`
  std::shared_ptr<SliceTiles> tiles{};  ///< finer than `field`; null: there are none
  Similarity pose{};                    ///< of the frame of `tiles` in the hand frame
  double low = 0.0;                     ///< shown black, the field's own unit
  double high = 1.0;                    ///< shown white
  double least = 0.0, most = 1.0;       ///< of all values
  detail::ColorMap colors = detail::grey_colors(0.0, 1.0);  ///< over 0 … 1
  Similarity map;                                           ///< hand to world
  bool medical = false;
};
/// For a field of the scene; empty: the one that its slices show, else its label map, its flow (as speed), the field of a
/// layer, or that its first mode reads. The window is that of the file's unit, else of the data. Throws nothing: without such a
/// field `field` is null.
SliceLook slice_look_of(const Scene& scene, const std::string& field = {});

/// Gives a look of a volume larger than memory its tiles: those of `last`, if they are of its octaves.
void take_tiles(const Scene& scene, const std::shared_ptr<SliceTiles>& last, SliceLook& look);

/// A look with the octave that has about a voxel a pixel, where that has at most 256 voxels along each axis; other looks
/// themselves. Reads voxels: blocks; any thread. Throws LoadError if they cannot be read any more.
SliceLook in_fine_octave(const Scene& scene, SliceLook look);

/// A named window of values.
struct ValueWindow {
  QString name;
  double low, high;  ///< the field's own unit
};
/// Windows for a look: of CT for Hounsfield units, of the data, and the whole range. The first is the look's own.
std::vector<ValueWindow> windows_of(const SliceLook& look);

/// Value of a scalar field, magnitude of a vector field; none without data.
std::optional<double> value_at(const Field& field, const Vec3& at_m);
/// Name of a field of the scene in the window, without the volume's where there is one volume; a vector field by its
/// magnitude: "|velocity|", "speed" of a flow without a name.
QString field_words(const Scene& scene, const std::string& field);

/// Left drag: touch within the slice; right drag: window (across) and level (up); wheel: through slices; Ctrl and wheel: zoom;
/// middle button: pan; double click: `enlarge_asked`, or `value_asked` while values are picked.
class SliceView : public QWidget {
  Q_OBJECT
 public:
  /// \param axis  of the world, normal to the slice: 0, 1, 2
  explicit SliceView(int axis, QWidget* parent = nullptr);

  void start(const SliceLook& look, const Box& bounds_m);
  void set_look(const SliceLook& look);
  /// Moves the crosshair, hand frame, and the slice through it.
  void set_cross(const Vec3& at_m);
  /// Sets the hands, and the trail of the last of them, the led one. \param trail  oldest first
  void show_touch(std::vector<SeenHand> hands, const std::vector<TrailPoint>& trail, double most_n);
  QSize sizeHint() const override { return {240, 220}; }
  const detail::View& view() const { return view_; }
  QString title() const;
  /// The picture has a sample for each pixel; else a finer one follows soon.
  bool is_fine() const { return step_px_ == 1; }
  /// Tiles to be read for the picture, coarse first.
  const std::vector<TilePlace>& missing_tiles() const { return tiles_.missing; }
  /// Draws tiles of the look that were added.
  void show_tiles(std::span<const TilePlace> places);
  /// Value that the slice shows at a place, hand frame; none without data.
  std::optional<double> value_at(const Vec3& at_m) const;
  /// Texts of the last picture.
  const std::vector<PlacedText>& texts() const { return texts_; }
  /// Sets whether a double click picks the value there.
  void pick_values(bool on) { picks_ = on; }

 Q_SIGNALS:
  void hold_began(palpa::Vec3 at_m, palpa::Vec3 away);
  void hold_moved(palpa::Vec3 at_m, palpa::Vec3 away, double depth_m);
  void hold_ended(palpa::Vec3 away);
  void cross_moved(palpa::Vec3 at_m);
  void window_dragged(double low, double high);
  void value_asked(double value, palpa::Vec3 at_m);
  void enlarge_asked();
  /// `missing_tiles` has changed.
  void tiles_missing();
  /// The cursor is here, hand frame.
  void pointed(palpa::Vec3 at_m);
  void pointed_nowhere();

 protected:
  void paintEvent(QPaintEvent*) override;
  void resizeEvent(QResizeEvent*) override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void leaveEvent(QEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;

 private:
  enum class Drag { none, touch, window, move };
  Vec3 at_m(const QPointF& px) const;
  void sample(int step_px);
  void sample(const QRect& part);
  void find_tiles();
  QString octave_words() const;
  void paint_texts(Texts& shown);
  void stale();

  const int axis_;
  SliceLook look_;
  Box bounds_m_{};
  detail::View view_;
  QImage image_;
  int step_px_ = 1;  ///< between samples of the image
  TilesOfArea tiles_;
  QTimer refine_;
  Vec3 cross_m_;
  std::vector<SeenHand> hands_;
  std::vector<TrailPoint> trail_;
  std::vector<PlacedText> texts_;
  double most_n_ = 1.0;
  Drag drag_ = Drag::none;
  QPointF last_px_;
  bool picks_ = false;
};

}  // namespace palpa::explorer
