// Filter of DICOM words by fixed lists: names of protocols, scanners and sequences are free text and may identify a patient.
#pragma once

#include <string>
#include <string_view>

namespace palpa::reader {

/// Words of anatomy and technique, in lower case: "1A TRAUMA/PLAIN HEAD DM" is "trauma plain head". Empty: none is known.
std::string format_protocol(std::string_view text);

/// True if the element of the contrast agent names one: "NO" and "w/o" do not.
bool names_contrast_agent(std::string_view text);

/// Maker and model: "Philips Ingenuity CT". Empty: unknown maker.
std::string format_scanner(std::string_view maker, std::string_view model);

/// Reconstruction kernel by its usual names: "H31s", "STANDARD". Empty: another name.
std::string format_kernel(std::string_view text);

/// MR sequence: "3D spoiled gradient echo, inversion recovery (tfl3d1)". Empty: unknown.
/// \param kinds     SE, IR, GR, EP
/// \param variants  SK, MTC, SS, SP, MP
/// \param extent    2D, 3D
/// \param name      the maker's own; used only if it has the form of a sequence name
std::string format_sequence(std::string_view kinds, std::string_view variants, std::string_view extent, std::string_view name);

/// Quantity of a derived image: "phase map", "ADC map". Empty: the signal, or unknown.
std::string format_image_type(std::string_view text);

}  // namespace palpa::reader
