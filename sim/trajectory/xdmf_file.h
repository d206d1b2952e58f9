// The XDMF sidecar through which ParaView opens a trajectory: XML that names datasets of the HDF5
// file. Private to sim/.
#pragma once

#include <string>
#include <vector>

namespace weft::sim {

// Numbers or vectors at the points of a surface.
struct XdmfAttribute {
  std::string name;
  int components = 1;   // 3: vectors
  std::string dataset;  // [points] or [points, 3] float32
};

// A surface of one frame, as datasets of the HDF5 file.
struct XdmfSurface {
  std::string name;
  int points = 0;
  int triangles = 0;
  std::string triangle_dataset;  // [triangles, 3] int32
  std::string position_dataset;  // [points, 3]
  int position_bytes = 4;        // bytes per number; 8 for float64
  std::vector<XdmfAttribute> attributes;
};

// The sidecar, which is valid XML at any time. It is created under a temporary name and then
// renamed. An append replaces the closing tags by frames and new closing tags, in one write. The
// first frame lists the surfaces at rest, and later frames include these by XInclude. Cost per
// frame: O(surfaces that move).
class XdmfFile {
 public:
  XdmfFile() = default;
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;
  ~XdmfFile();

  // Creates the sidecar and replaces any file at `path`. `trajectory` is the name of the HDF5 file
  // in the same folder. Throws FileError.
  void create(const std::string& path, const std::string& trajectory,
              const std::vector<XdmfSurface>& at_rest);
  // Returns the text of the next frame, at `time` (s), for append(). Every frame must have the same
  // number of surfaces that move.
  std::string describe(double time, const std::vector<XdmfSurface>& moving);
  // Writes the texts of one or more frames. Throws FileError.
  void append(const std::string& frames);

 private:
  std::string text_of(const XdmfSurface& surface) const;
  void write_at(long offset, const std::string& text) const;

  std::string path_;
  std::string trajectory_;
  int descriptor_ = -1;
  std::string at_rest_;    // text for the surfaces at rest in the next frame; empty: none
  bool includes_ = false;  // at_rest_ is an include of the first frame's surfaces
  long end_ = 0;           // offset at which the closing tags start
};

}  // namespace weft::sim
