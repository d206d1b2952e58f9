// The XDMF sidecar through which ParaView opens a trajectory: XML that names datasets of the HDF5
// file. Private to sim/.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Returns a notice if the trajectory has no sidecar, because XML cannot hold its name: bytes that
// are not UTF-8, or control characters. Returns an empty string for other names.
std::string no_sidecar_notice(const std::string& trajectory);

// True if a version of Weft wrote the file at `path`, by how it begins, or if the file is empty, as
// the death of the machine may leave it.
bool is_own_sidecar(const std::string& path);

// An attribute of a surface: numbers or vectors at its points.
struct XdmfAttribute {
  std::string name;
  int components = 1;   // 1: numbers, 3: vectors
  std::string dataset;  // path of a float32 dataset [points] or [points, 3]
};

// A surface in one frame, described by datasets of the HDF5 file.
struct XdmfSurface {
  std::string name;
  int points = 0;
  int triangles = 0;
  // Path of an int32 dataset [triangles, 3]; empty for separate points.
  std::string triangle_dataset;
  std::string position_dataset;  // path of a dataset of three numbers per point
  int position_bytes = 4;        // bytes per number of the positions: 4 or 8
  std::vector<XdmfAttribute> attributes;
};

// The sidecar, which is valid XML after each call. It is created under a temporary name and then
// renamed. append() overwrites the closing tags with frames and new closing tags, usually in one
// write. The first frame lists the surfaces that do not move, and later frames include them by
// XInclude. Cost per frame: O(surfaces that move).
class XdmfFile {
 public:
  XdmfFile() = default;
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;
  ~XdmfFile();

  // Must be called first. `trajectory` is the name of the HDF5 file in the folder of the sidecar.
  // `at_rest` lists the surfaces that do not move. If XML cannot hold the name, create() and
  // append() do nothing.
  void begin(const std::string& trajectory, const std::vector<XdmfSurface>& at_rest);
  // Creates the sidecar without frames, and replaces any file at `path`. Throws FileError.
  void create(const std::string& path);
  // Returns the text of the next frame, at `time` (s), for append(). `moving` lists the surfaces
  // that move; their number must be the same for every frame.
  std::string describe(double time, const std::vector<XdmfSurface>& moving);
  // Writes the texts of one or more frames. Precondition: create() has been called. Throws
  // FileError; the file then lists the frames before these.
  void append(const std::string& frames);

 private:
  std::string text_of(const XdmfSurface& surface) const;
  // Returns false, with errno, if only a part of the text could be written.
  bool write_at(long offset, const std::string& text) const;

  std::string path_;
  std::string trajectory_;  // escaped for XML
  bool has_name_ = true;    // false if XML cannot hold the trajectory's name
  int descriptor_ = -1;
  std::string at_rest_;    // text of the next frame about surfaces that do not move
  bool includes_ = false;  // true if at_rest_ includes the first frame's surfaces by XInclude
  long end_ = 0;           // offset (bytes) at which the closing tags start
};

}  // namespace weft::sim
