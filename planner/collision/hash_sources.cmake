# Writes OUTPUT: the function filter_code(), which returns a hash of the sources below ROOT that the filter of link pairs
# depends on. Called as cmake -DROOT=… -DOUTPUT=… -P.
cmake_minimum_required(VERSION 3.25)
file(GLOB sources LIST_DIRECTORIES false ${ROOT}/planner/model/* ${ROOT}/planner/collision/* ${ROOT}/planner/simd/* ${ROOT}/world/model/*)
set(hashes "")
foreach(source IN LISTS sources)
  file(SHA256 ${source} hash)
  string(APPEND hashes ${hash})
endforeach()
string(SHA256 hash "${hashes}")
file(WRITE ${OUTPUT} "#include \"planner/collision/filter_cache.hpp\"\n\n"
     "namespace hecaton::planner {\n\nstd::string_view filter_code() {\n  return \"${hash}\";\n}\n\n}  // namespace hecaton::planner\n")
