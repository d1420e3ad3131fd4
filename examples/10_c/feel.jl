# The same library from Julia: julia feel.jl [libpalpa.so.0.1]
const lib = isempty(ARGS) ? "libpalpa.so.0.1" : ARGS[1]

struct Probe
    size::UInt32
    buttons::UInt32
    valid::Int32
    has_velocity::Int32
    position_m::NTuple{3,Float64}
    velocity_m_per_s::NTuple{3,Float64}
    turn::NTuple{4,Float64}
end

struct Tick
    size::UInt32
    status::Int32
    force_n::NTuple{3,Float64}
    proxy_m::NTuple{3,Float64}
    rest::NTuple{43,Float64}  # the other fields of palpa_tick
end

checked(handle) = handle == C_NULL ? error(unsafe_string(@ccall lib.palpa_last_error()::Cstring)) : handle

toml = """palpa = 1
coupling = {stiffness_n_per_m = 400}
volume.head = {analytic = "head_phantom"}
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "head"
level = [{name = "skin", value = -300, strength_n = 0.8, friction_n = 0.1}]
"""

scene = checked(@ccall lib.palpa_scene_parse(toml::Cstring, C_NULL::Ptr{UInt8})::Ptr{Cvoid})
session = checked(@ccall lib.palpa_session_new(scene::Ptr{Cvoid}, 0.0::Cdouble)::Ptr{Cvoid})
@ccall lib.palpa_scene_free(scene::Ptr{Cvoid})::Cvoid
zeros3 = (0.0, 0.0, 0.0)
tick = Ref(Tick(sizeof(Tick), 0, zeros3, zeros3, ntuple(_ -> 0.0, 43)))
for n in 0:40  # a hand presses, 1 ms a tick
    hand = Ref(Probe(sizeof(Probe), 0, 1, 0, (0.0, 0.02, 0.05 - 1e-4n), zeros3, (1.0, 0.0, 0.0, 0.0)))
    result = @ccall lib.palpa_session_tick(session::Ptr{Cvoid}, hand::Ptr{Probe}, 1e-3::Cdouble, tick::Ptr{Tick})::Int32
    result == 0 || error(unsafe_string(@ccall lib.palpa_last_error()::Cstring))
end
@ccall lib.palpa_session_free(session::Ptr{Cvoid})::Cvoid
force_n = sqrt(sum(abs2, tick[].force_n))
println("force ", round(force_n; digits = 3), " N")
exit(force_n > 0.1 ? 0 : 1)
