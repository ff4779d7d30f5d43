# SPDX-License-Identifier: BSD-3-Clause
# Kernels: inner loops in files of their own, of which some are compiled once more for wider
# instructions and chosen at run time.
include(CheckCXXCompilerFlag)

# What lidar_mapping::InstructionSet (common/instruction_set.hpp) asks the processor for, set by set.
set(LIDAR_MAPPING_AVX2_FLAGS -mavx2 -mfma)
set(LIDAR_MAPPING_AVX512_FLAGS -mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma
                               -mprefer-vector-width=512)

# lidar_mapping_kernel(FILE [INSTRUCTIONS AVX2|AVX512] [OPTIONS ...])
# A file for a set of instructions is compiled with all of the set's flags and with
# LIDAR_MAPPING_HAS_<set> defined where the compiler knows them, else with neither.
function(lidar_mapping_kernel file)
  cmake_parse_arguments(ARG "" "INSTRUCTIONS" "OPTIONS" ${ARGN})
  # A multiplication that is fused with an addition by the compiler gives other bits.
  set(options ${ARG_OPTIONS} -ffp-contract=off)
  if(ARG_INSTRUCTIONS)
    set(flags ${LIDAR_MAPPING_${ARG_INSTRUCTIONS}_FLAGS})
    list(JOIN flags " " question)
    # CMake keeps the answer under this name, which therefore says what was asked.
    string(MAKE_C_IDENTIFIER "LIDAR_MAPPING_COMPILES ${question}" answer)
    check_cxx_compiler_flag("${question}" ${answer})
    if(${answer})
      list(APPEND options ${flags})
      set_source_files_properties(${file} PROPERTIES
        COMPILE_DEFINITIONS LIDAR_MAPPING_HAS_${ARG_INSTRUCTIONS})
    endif()
  endif()
  # Precompiled headers are made without these options.
  set_source_files_properties(${file} PROPERTIES COMPILE_OPTIONS "${options}"
                                                 SKIP_PRECOMPILE_HEADERS ON)
endfunction()
