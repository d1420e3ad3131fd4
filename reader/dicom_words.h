// What may leave a DICOM header as words: those of lists of ours. Names of protocols, scanners and sequences are free text, in
// which somebody may have written a patient's name, so of each only words that are known to be none get through.
#pragma once

#include <string>
#include <string_view>

namespace palpa::reader {

/// Words of anatomy and of technique, in lower case: "1A TRAUMA/PLAIN HEAD DM" is "trauma plain head". Empty: none is known.
std::string words_of_protocol(std::string_view text);

/// Whether the element of the contrast agent names one: "NO" and "w/o" do not.
bool names_contrast_agent(std::string_view text);

/// Maker and model: "Philips Ingenuity CT". Empty: the maker is not known.
std::string words_of_scanner(std::string_view maker, std::string_view model);

/// A reconstruction kernel as makers name them: "H31s", "STANDARD". Empty: another name.
std::string words_of_kernel(std::string_view text);

/// An MR sequence: "3D spoiled gradient echo, inversion recovery (tfl3d1)". Empty: nothing is known.
/// \param kinds     SE, IR, GR, EP
/// \param variants  SK, MTC, SS, SP, MP
/// \param extent    2D, 3D
/// \param name      the maker's, said where it has the form of one
std::string words_of_sequence(std::string_view kinds, std::string_view variants, std::string_view extent,
                              std::string_view name);

/// What an image shows where that is not the signal: "phase map", "ADC map". Empty: the signal, or not known.
std::string words_of_image_type(std::string_view text);

}  // namespace palpa::reader
