#include "library_words.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

namespace palpa::reader {
namespace {

/// Lower case. Adding a word: it is passed on from any file; removing one: sentences are harder to understand.
const std::set<std::string_view>& words() {
  static const std::set<std::string_view> all{
      // Sentences.
      "a", "after", "all", "allocate", "already", "an", "and", "any", "are", "as", "at", "be", "because", "been", "before",
      "between", "both", "but", "by", "can", "can't", "cannot", "closing", "completely", "consistent", "contain", "contains",
      "copy", "could", "couldn't", "create", "did", "didn't", "different", "do", "does", "doesn't", "don't", "each", "empty",
      "end", "enough", "error", "exactly", "exist", "expected", "failed", "few", "finding", "first", "for", "found", "from",
      "get", "given", "got", "had", "has", "have", "hit", "if", "in", "incorrect", "initialize", "inside", "instead", "into",
      "invalid", "is", "isn't", "it", "its", "known", "large", "last", "length", "less", "many", "match", "maximum", "minimum",
      "mismatch", "mismatched", "missing", "more", "must", "needs", "negative", "no", "not", "null", "of", "old", "on", "one",
      "only", "open", "opening", "or", "other", "out", "outside", "parse", "parsing", "position", "positive", "premature",
      "prior", "problem", "provide", "provided", "read", "reading", "required", "same", "says", "see", "seek", "set", "short",
      "should", "size", "skip", "small", "some", "specified", "stream", "such", "than", "that", "the", "then", "there", "this",
      "to", "token", "too", "trouble", "trying", "two", "unable", "unclosed", "unexpected", "unknown", "unrecognized",
      "unsupported", "until", "use", "using", "valid", "value", "values", "version", "was", "well", "well-formed", "were",
      "when", "which", "while", "with", "within", "without", "wrong", "zero",
      // Files and their parts.
      "appended", "array", "arrays", "ascii", "attribute", "attributes", "axes", "axis", "base64", "big", "binary", "block",
      "blocks", "bounds", "box", "buffer", "byte", "bytes", "bz2", "case", "cell", "cells", "character", "characters", "char",
      "column", "component", "components", "compressed", "compression", "connectivity", "contents", "coordinates", "count",
      "data", "dataset", "datasets", "detached", "dictionary", "dimension", "dimensions", "directory", "dictionaries", "double",
      "element", "elements", "encoding", "endian", "entry", "eof", "extent", "extents", "face", "faces", "field", "fields",
      "file", "files", "float", "floats", "format", "ghost", "grid", "gzip", "header", "image", "index", "input", "int",
      "integer", "key", "key/value", "keyword", "kind", "kinds", "level", "line", "lines", "list", "little", "long", "magic",
      "matrix", "memory", "mesh", "name", "names", "normals", "number", "numbers", "object", "offset", "offsets", "order",
      "origin", "output", "pair", "patch", "path", "piece", "pieces", "point", "points", "polyhedra", "precision", "range",
      "rank", "raw", "record", "rectilinear", "resource", "row", "scalar", "scalars", "scale", "separator", "sizes", "space",
      "spacing", "spacings", "start", "string", "structured", "system", "table", "tag", "tensor", "tensors", "text", "time",
      "type", "types", "uniform", "units", "unsigned", "unstructured", "vector", "vectors", "vertex", "volume", "whole", "word",
      "xml", "zlib",
      // VTK types that Palpa does not read.
      "collection", "graph", "hypertreegrid", "hierarchicalboxdataset", "molecule", "overlappingamr", "partitioneddataset",
      "partitioneddatasetcollection", "phypertreegrid", "polydata", "ppolydata", "ptable", "tree", "vtkhierarchicalboxdataset",
      "vtkmultiblockdataset", "vtknonoverlappingamr", "vtkoverlappingamr", "vtkpartitioneddataset",
      "vtkpartitioneddatasetcollection",
      // Header keys.
      "centerings", "centers", "compresseddata", "dimsize", "directions", "elementdatafile", "elementspacing", "elementtype",
      "frame", "frames", "labels", "maxs", "measurement", "mins", "ndims", "nrrd", "nrrds", "objecttype", "sample", "skip",
      "thicknesses", "transformmatrix", "vtk", "dicom", "nifti", "metaimage", "gdcm", "hdf5", "openfoam", "plot3d"};
  return all;
}

bool is_known(std::string_view word) {
  while (!word.empty() && std::ispunct(static_cast<unsigned char>(word.front())) != 0) word.remove_prefix(1);
  while (!word.empty() && std::ispunct(static_cast<unsigned char>(word.back())) != 0) word.remove_suffix(1);
  // A short whole number is an offset or a count.
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (!word.empty() && word.size() <= 4 && std::ranges::all_of(word, digit)) return true;
  std::string lower(word);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return lower.empty() || words().contains(lower);
}

}  // namespace

std::string known_words(std::string_view sentence) {
  std::string outside;  // of quotes
  bool inside = false;
  for (const char c : sentence) {
    if (c == '"') {
      inside = !inside;
      if (inside) outside += " \"…\" ";
    } else if (!inside) {
      outside += c;
    }
  }
  std::istringstream parts(outside);
  std::string joined, last;
  for (std::string word; parts >> word;) {
    if (word == "\"…\"" || !is_known(word)) word = "…";
    if (word == "…" && last == "…") continue;
    joined += (joined.empty() ? "" : " ") + word;
    last = word;
  }
  return joined;
}

}  // namespace palpa::reader
