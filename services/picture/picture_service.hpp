#pragma once
/// Pictures and films of a cell: the page of the view in a browser without a window, which draws and encodes them
/// (view/page/src/picture.ts).

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/replay/replay.hpp"
#include "services/view/arm_drawing.hpp"

namespace hecaton::services::picture {

/// The recording that is shown; its cell and drawings are those of its files. Times are since its begin.
struct Recorded {
  replay::Replay& replay;
  double from = 0.0;   ///< of a picture, or of the first frame of a film [s]
  double until = 0.0;  ///< of the last frame of a film [s]
};

struct PictureOptions {
  bool film = false;          ///< WebM instead of PNG; needs a recording
  int width = 1280;           ///< [px]
  int height = 720;           ///< [px]
  double frame_rate = 25.0;   ///< of a film [Hz]
  double speed = 1.0;         ///< of the recording in a film
  std::string view = "free";  ///< or "left", "top", "front", "side"
  bool dark = false;
  std::vector<std::string> layers;  ///< of the page: "goals", "ways", "halos", "planning", "binding", "names", "trails"
};

/// The browser on the PATH; throws std::runtime_error with a sentence when there is none.
[[nodiscard]] std::string find_browser();

/// The whole file: PNG or WebM. Without a recording the arms stand where the cell starts. `progress`: called for each
/// frame of a film, with the number of frames. `interrupted`: returns true when the work shall end; the result is then
/// empty. One thread. Throws std::runtime_error with a sentence when no browser runs, or it draws nothing.
[[nodiscard]] std::optional<std::string> take_picture(const config::CellFile& cell, const view::Drawings& drawings,
                                                      const std::optional<Recorded>& recorded,
                                                      const PictureOptions& options,
                                                      const std::function<void(std::size_t, std::size_t)>& progress,
                                                      const std::function<bool()>& interrupted);

}  // namespace hecaton::services::picture
