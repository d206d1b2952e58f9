#include "sim/trajectory/xdmf_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "sim/case/case_text.h"
#include "sim/trajectory/leftover_files.h"
#include "sim/trajectory/trajectory.h"

namespace weft::sim {
namespace {

// The element by which is_own_sidecar() knows the sidecars of all versions of Weft.
const std::string opening_tag =
    "<Grid Name=\"trajectory\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
const std::string closing_tags = "  </Grid>\n </Domain>\n</Xdmf>\n";

std::string escape(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

bool is_xml_text(const std::string& name) { return printable(name) == name; }

[[noreturn]] void fail(const std::string& path) {
  throw FileError(path + ": cannot write: " + std::strerror(errno));
}

}  // namespace

std::string no_sidecar_notice(const std::string& trajectory) {
  const std::string name = std::filesystem::path(trajectory).filename().string();
  if (is_xml_text(name)) return "";
  return "no .xdmf is written: XML cannot hold the name " + in_quotes(name) +
         ", which is not UTF-8 or has control characters";
}

bool is_own_sidecar(const std::string& path) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return false;
  std::string begin(512, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file) return false;
  file.read(begin.data(), std::ssize(begin));
  begin.resize(static_cast<std::size_t>(file.gcount()));
  return begin.empty() || begin.find(opening_tag) != std::string::npos;
}

XdmfFile::~XdmfFile() {
  if (descriptor_ >= 0) close(descriptor_);
}

void XdmfFile::begin(const std::string& trajectory, const std::vector<XdmfSurface>& at_rest) {
  has_name_ = is_xml_text(trajectory);
  trajectory_ = escape(trajectory);
  for (const XdmfSurface& surface : at_rest) at_rest_ += text_of(surface);
}

void XdmfFile::create(const std::string& path) {
  if (!has_name_) return;
  path_ = path;
  const std::string temporary = temporary_path(path);
  descriptor_ = open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(path);
  const std::string head =
      "<?xml version=\"1.0\"?>\n"
      "<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\">\n <Domain>\n  " +
      opening_tag;
  end_ = static_cast<long>(head.size());
  if (!write_at(0, head + closing_tags) || std::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error = errno;
    unlink(temporary.c_str());
    errno = error;
    fail(path);
  }
}

std::string XdmfFile::text_of(const XdmfSurface& surface) const {
  const bool is_of_points = surface.triangle_dataset.empty();
  std::string text =
      "    <Grid Name=\"" + escape(surface.name) +
      "\">\n     <Topology TopologyType=" + (is_of_points ? "\"Polyvertex\"" : "\"Triangle\"") +
      " NumberOfElements=\"" + std::to_string(is_of_points ? surface.points : surface.triangles) +
      (is_of_points ? "\" NodesPerElement=\"1\">\n" : "\">\n");
  const auto add_item = [&](const char* type, int bytes, int rows, int components,
                            const std::string& dataset) {
    text += std::string("      <DataItem Format=\"HDF\" NumberType=\"") + type + "\" Precision=\"" +
            std::to_string(bytes) + "\" Dimensions=\"" + std::to_string(rows) +
            (components > 1 ? ' ' + std::to_string(components) : "") + "\">" + trajectory_ + ':' +
            escape(dataset) + "</DataItem>\n";
  };
  if (!is_of_points) add_item("Int", 4, surface.triangles, 3, surface.triangle_dataset);
  text += "     </Topology>\n     <Geometry GeometryType=\"XYZ\">\n";
  add_item("Float", surface.position_bytes, surface.points, 3, surface.position_dataset);
  text += "     </Geometry>\n";
  for (const XdmfAttribute& attribute : surface.attributes) {
    text += "     <Attribute Name=\"" + escape(attribute.name) + "\" AttributeType=\"" +
            (attribute.components > 1 ? "Vector" : "Scalar") + "\" Center=\"Node\">\n";
    add_item("Float", 4, surface.points, attribute.components, attribute.dataset);
    text += "     </Attribute>\n";
  }
  return text + "    </Grid>\n";
}

std::string XdmfFile::describe(double time, const std::vector<XdmfSurface>& moving) {
  std::ostringstream head;
  head.precision(17);
  head << "   <Grid Name=\"frame\" GridType=\"Collection\" CollectionType=\"Spatial\">\n"
       << "    <Time Value=\"" << time << "\"/>\n";
  std::string text = head.str();
  for (const XdmfSurface& surface : moving) text += text_of(surface);
  text += at_rest_ + "   </Grid>\n";
  if (!at_rest_.empty() && !includes_) {
    includes_ = true;
    at_rest_ = "    <xi:include xpointer=\"xpointer(/Xdmf/Domain/Grid/Grid[1]/Grid[position()&gt;" +
               std::to_string(moving.size()) + "])\"/>\n";
  }
  return text;
}

void XdmfFile::append(const std::string& frames) {
  if (!has_name_) return;
  if (!write_at(end_, frames + closing_tags)) {
    // The former closing tags take no new room, so a full disk has it for them.
    const int error = errno;
    const long former_size = end_ + static_cast<long>(closing_tags.size());
    const bool restored = write_at(end_, closing_tags) && ftruncate(descriptor_, former_size) == 0;
    static_cast<void>(restored);  // the first error is the one to report
    errno = error;
    fail(path_);
  }
  end_ += static_cast<long>(frames.size());
}

bool XdmfFile::write_at(long offset, const std::string& text) const {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = pwrite(descriptor_, text.data() + done, text.size() - done,
                                 offset + static_cast<long>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

}  // namespace weft::sim
