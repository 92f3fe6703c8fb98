/*
 * dermis: real-time character skin with contact and volume, on Vulkan.
 *
 * A context is a device, a rig a prepared character, a deformer one instance of a rig in a context, or several that share its
 * fields: matrices of the joints go in, positions and normals come out. A mesh can be bent along a spine, and a captured sequence
 * made a sphere-mesh, without any of these; particles bounce off a level of a sphere-mesh in a context.
 *
 * Handles are numbers. Zero is none; a handle that is used after its object was destroyed is refused with an error. An
 * object stays alive as long as another one uses it, so that they may be destroyed in any order.
 *
 * Functions may be called on any thread; calls on one object wait for each other. All but dm_api_version and dm_last_error
 * return a dm_result; dm_last_error says what went wrong.
 *
 * Structs begin with their size, which the caller sets, also where the function fills the rest. A size of an earlier version,
 * which had fewer members, will do: those that it lacks are 0. Text is UTF-8. Matrices are
 * 16 numbers, column-major. Rest space is that in which the mesh is modelled, model space that of the posed result. Arrays
 * may have any alignment. Nothing that a caller passes is kept, but the log of a context.
 *
 * Generated from src/capi by `cargo xtask header`.
 */

#ifndef DERMIS_H
#define DERMIS_H

#include <stddef.h>
#include <stdint.h>

/* Version of this interface; dm_context_desc has the one that a program was compiled with. */
#define DM_API_VERSION 1

/* Level of a message: a call failed, or Vulkan's validation layers complain. */
#define DM_LOG_ERROR 0

/* Level of a message: something was mended or left out. */
#define DM_LOG_WARNING 1

/* Level of a message: for information. */
#define DM_LOG_INFO 2

/* Flag of a context: compute on the CPU, without Vulkan. The same results up to rounding, slowly. */
#define DM_CONTEXT_CPU 1

/* Flag of a context: watch every call by Vulkan's validation layers, which have to be installed. */
#define DM_CONTEXT_VALIDATION 2

/* Flag of a context: measure times on the device, for dm_deformer_timings. */
#define DM_CONTEXT_TIMESTAMPS 4

/* Feature of a device: VK_KHR_synchronization2, the extension with its feature. Without it older barriers are recorded. */
#define DM_FEATURE_SYNCHRONIZATION2 1

/* Feature of an instance, where the host has turned it on: VK_EXT_debug_utils. With it objects have names and passes have labels. */
#define DM_FEATURE_DEBUG_UTILS 2

/* Most extensions that dermis can use. */
#define DM_MAX_EXTENSIONS 8

/* Flag of a preparation: compute weights by heat diffusion though the character has some. */
#define DM_RIG_HEAT_WEIGHTS 1

/* Operator of the method: union in implicit skinning, contact in tracking. */
#define DM_OPERATOR_DEFAULT 0

/* Operator: union, with a crease. */
#define DM_OPERATOR_UNION 1

/* Operator: blend, without a crease (implicit skinning). */
#define DM_OPERATOR_BLEND 2

/* Operator: bulge in contact. */
#define DM_OPERATOR_BULGE 3

/* Operator: contact surface (tracking). */
#define DM_OPERATOR_CONTACT 4

/* Operator: the profile curve of dm_rig_options (tracking). */
#define DM_OPERATOR_PROFILE 5

/* Curve over the angle of two surfaces: the operator's own. */
#define DM_CURVE_DEFAULT 0

/* Curve: for elbows and knees. */
#define DM_CURVE_ELBOW 1

/* Curve: for fingers. */
#define DM_CURVE_FINGER 2

/* Curve of a controller: as deep as skin folds. */
#define DM_CURVE_FOLD 3

/* Curve of a controller: no contact. */
#define DM_CURVE_NEVER 4

/* Curve: through the three points that are given with it. */
#define DM_CURVE_POINTS 5

/* Form of a profile: straight segments. */
#define DM_PROFILE_POLYLINE 0

/* Form of a profile: a uniform cubic B-spline from the first point to the last; a point given three times is a corner. */
#define DM_PROFILE_SPLINE 1

/* Number of frames that may be on the device at once: frame slots are below it. */
#define DM_FRAME_SLOTS 2

/* Format of normals: none are written. */
#define DM_NORMAL_NONE 0

/* Format of normals: three 32-bit floats. */
#define DM_NORMAL_F32 1

/* Format of normals: three signed normalised bytes and a byte of 0. */
#define DM_NORMAL_SNORM8 2

/* No other queue family. */
#define DM_SAME_FAMILY UINT32_MAX

/* Method: linear blend skinning. */
#define DM_LBS 0

/* Method: dual-quaternion skinning. */
#define DM_DQS 1

/* Method: implicit skinning (Vaillant et al. 2013), the default. */
#define DM_IMPLICIT 2

/* Method: iso-surface tracking (Vaillant et al. 2014), from the skin of the pose before. */
#define DM_TRACKING 3

/* Map of fleshing: flesh gives way from and to the spine. */
#define DM_MAP_RADIAL 0

/* Map of fleshing: flesh gives way in the plane of the bend. */
#define DM_MAP_NORMAL 1

/* Map of fleshing: flesh gives way across the plane of the bend. */
#define DM_MAP_BINORMAL 2









/* Kind of a spine: the polynomial through 2 to 16 points. */
#define DM_SPINE_POLYNOMIAL 0

/* Kind of a spine: the quintic B-spline through its points; a last point that repeats the first closes it. */
#define DM_SPINE_BSPLINE 1

/* Kind of a spine: a smooth curve through densely given points; a last point that repeats the first closes it. */
#define DM_SPINE_POLYLINE 2

/* Kind of a spine: a circular arc; a full circle is closed. */
#define DM_SPINE_ARC 3

/* Kind of a spine: a helix. */
#define DM_SPINE_HELIX 4

/* Flag of a sphere-mesh: collapses may turn triangles over, instead of being put off. */
#define DM_SPHERE_MESH_ALLOW_INVERSION 1

/* Flag of a level: as the hierarchy has it, without its connectivity optimised. */
#define DM_LEVEL_PLAIN 1

/* What became of a moving sphere: it touches nothing. */
#define DM_HIT_NONE 0

/* What became of a moving sphere: it touches. */
#define DM_HIT_TOUCHED 1

/* What became of a moving sphere: it began inside, and is pushed out. */
#define DM_HIT_PUSHED 2

/*
 What a function returns; every function but dm_api_version and dm_last_error has one.

 Where it is not DM_OK, nothing has been written through pointers and objects are as before, unless the function says so, and
 dm_last_error tells more. What failed by DM_ERROR_MEMORY may be tried again.
 */
enum dm_result
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif  /* defined(__cplusplus) || __STDC_VERSION__ >= 202311L */
 {
    /* Success. */
    DM_OK = 0,
    /* A pointer is NULL that must not be. */
    DM_ERROR_NULL = 1,
    /* The size in a struct is not one that this version knows. */
    DM_ERROR_STRUCT_SIZE = 2,
    /* A handle is zero, of another kind, or of an object that was destroyed. */
    DM_ERROR_HANDLE = 3,
    /* Objects of different contexts. */
    DM_ERROR_FOREIGN = 4,
    /* The program was compiled with a header of another version. */
    DM_ERROR_VERSION = 5,
    /* An argument or a member of a struct is out of its range. */
    DM_ERROR_ARGUMENT = 6,
    /* A file cannot be read, or its content cannot be used. */
    DM_ERROR_FILE = 7,
    /* A pose has a matrix that is not finite, not affine or without inverse. */
    DM_ERROR_POSE = 8,
    /* Memory ran out, or the budget would be passed. */
    DM_ERROR_MEMORY = 9,
    /* A Vulkan call failed. */
    DM_ERROR_VULKAN = 10,
    /*
     The device was lost. From the call that finds it on, every function of its context and of what was made in it returns
     this and does nothing, but the destroying ones, which succeed; the context's log is told once. Contexts may be made anew,
     by dm_context_adopt when the host has a new device.
     */
    DM_ERROR_DEVICE_LOST = 11,
    /* No Vulkan loader or no device that fits. */
    DM_ERROR_NO_DEVICE = 12,
    /* An array of the caller has not the length that it has to have; the message says which. */
    DM_ERROR_SIZE = 13,
    /* A defect in dermis. The object that was in use can only be destroyed: all other calls on it return this. */
    DM_ERROR_PANIC = 14
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum dm_result dm_result;
#else
typedef int32_t dm_result;
#endif  /* __STDC_VERSION__ >= 202311L */
#endif  /* __cplusplus */

/*
 Receives messages of a context: its own user pointer, DM_LOG_ERROR, DM_LOG_WARNING or DM_LOG_INFO, and text in UTF-8
 that is valid during the call only.

 It is called within calls of dermis, by the thread that made the call; calls on several threads may call it at once.
 No object is locked meanwhile, so that it may call dermis. It must return: neither throw nor jump. NULL for none.
 */
typedef void (*dm_log)(void *user, int32_t level, const char *message);

/* How a context is made. Zeros besides size and api_version choose the best device. */
typedef struct dm_context_desc {
    /* sizeof(dm_context_desc). */
    uint32_t size;
    /* DM_API_VERSION. */
    uint32_t api_version;
    /* DM_CONTEXT_CPU, DM_CONTEXT_VALIDATION and DM_CONTEXT_TIMESTAMPS, or-ed; the latter two do nothing on the CPU. */
    uint32_t flags;
    /*
     Part of a device's name, in any case, or its number in Vulkan's order, in UTF-8; NULL for the best: discrete before
     integrated before software. Not read with DM_CONTEXT_CPU.
     */
    const char *device;
    /* Most bytes of device memory in use at once; 0 for no bound but the device's. */
    uint64_t budget;
    /* Receives messages; may be NULL. */
    dm_log log;
    /* First argument of log, kept as long as the context or a deformer in it exists. */
    void *log_user;
} dm_context_desc;

/* A device, or the CPU in its place. Zero is no context. */
typedef struct dm_context {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_context;

/* Device memory in use, in bytes by what it is for. All zero for a context on the CPU. */
typedef struct dm_memory {
    /* sizeof(dm_memory), set by the caller. */
    uint32_t size;
    /* Implicit fields of the bones. */
    uint64_t fields;
    /* Topology, weights and rest state of meshes. */
    uint64_t mesh;
    /* Operator volumes. */
    uint64_t operators;
    /* Poses on their way to the device. */
    uint64_t pose_ring;
    /* State and scratch of frames, staging. */
    uint64_t transient;
    /* Results on their way back. */
    uint64_t readback;
    /* Sum of all above. */
    uint64_t total;
    /* Number of buffers and images. */
    uint64_t buffers;
} dm_memory;

/*
 Receives one buffer or image of dm_context_allocations: the user pointer, the member of dm_memory that it is counted in
 and its name, both valid during the call only, and its bytes, alignment included.
 */
typedef void (*dm_allocation_report)(void *user, const char *class_name, const char *name, uint64_t bytes);

/* A device, as dm_devices reports it. Text is valid during the call only. */
typedef struct dm_device_info {
    /* sizeof(dm_device_info), set by dermis. */
    uint32_t size;
    /* Row in Vulkan's order, which dm_context_desc.device takes as text. */
    uint32_t index;
    /* Name that the driver gives. */
    const char *name;
    /* Driver and its version. */
    const char *driver;
    /* Vulkan version, as major.minor.patch. */
    const char *api;
    /* "discrete", "integrated", "virtual", "cpu" or "other". */
    const char *kind;
} dm_device_info;

/* Receives one device of dm_devices: the user pointer and what there is to know, valid during the call only. */
typedef void (*dm_device_report)(void *user, const struct dm_device_info *device);

/* Any function; to be cast to its own type. */
typedef void (*dm_function)(void);

/* vkGetInstanceProcAddr, as PFN_vkGetInstanceProcAddr cast to this type. */
typedef dm_function (*dm_get_instance_proc_addr)(void *instance, const char *name);

/* What a host that is about to create its device may turn on for dermis. Besides, timelineSemaphore has to be on. */
typedef struct dm_vulkan_requirements {
    /* sizeof(dm_vulkan_requirements), set by the caller. */
    uint32_t size;
    /* DM_FEATURE_SYNCHRONIZATION2 where the device offers it. */
    uint32_t features;
    /* A queue family that does compute, graphics as well where there is one. */
    uint32_t queue_family;
    /* Entries of extensions in use. */
    uint32_t extension_count;
    /* Names of device extensions behind the features; the text is dermis' own and stays. */
    const char *extensions[DM_MAX_EXTENSIONS];
} dm_vulkan_requirements;

/* A device of the host's. dermis creates on it what deformers need and destroys that again, and nothing else. */
typedef struct dm_vulkan_desc {
    /* sizeof(dm_vulkan_desc). */
    uint32_t size;
    /* DM_API_VERSION. */
    uint32_t api_version;
    /* From here all functions are loaded. */
    dm_get_instance_proc_addr get_instance_proc_addr;
    /* VkInstance, made for Vulkan 1.2 or newer. */
    void *instance;
    /* VkPhysicalDevice, of Vulkan 1.2 or newer. */
    void *physical_device;
    /* VkDevice, with timelineSemaphore turned on. */
    void *device;
    /*
     VkQueue of the device. All functions of deformers may submit to it but dm_deformer_destroy and dm_frame_record; nobody
     else may use it meanwhile.
     */
    void *queue;
    /* Family of the queue, which has to do compute. */
    uint32_t queue_family;
    /* DM_FEATURE_SYNCHRONIZATION2 and DM_FEATURE_DEBUG_UTILS, or-ed: what the host has turned on. */
    uint32_t features;
    /* Most bytes of device memory that dermis may have in use at once; 0 for no bound but the device's. */
    uint64_t budget;
    /* Receives messages; may be NULL. */
    dm_log log;
    /* First argument of log, kept as long as the context or a deformer in it exists. */
    void *log_user;
} dm_vulkan_desc;

/* How a joint's part meets its parent's part. Zeros besides size and name are the defaults. */
typedef struct dm_joint_options {
    /* sizeof(dm_joint_options). */
    uint32_t size;
    /* DM_OPERATOR_... */
    uint32_t op;
    /* Name of the joint, in UTF-8. */
    const char *name;
    /* Opening of the operator with the angle (implicit skinning): DM_CURVE_DEFAULT, _ELBOW, _FINGER or _POINTS. */
    uint32_t opening;
    /* Depth of the contact with the angle (tracking): DM_CURVE_... */
    uint32_t controller;
    /* Not 0: the skin of the joint's part follows it rigidly (tracking). */
    uint32_t rigid;
    /* Three pairs of cosine, rising, and opening from 0 (full operator) to 1 (union), for DM_CURVE_POINTS. */
    float opening_points[6];
    /* Three pairs of cosine, rising, and depth from 0 (union) to 1, for DM_CURVE_POINTS. */
    float controller_points[6];
    /*
     How abruptly the opening changes between its first two and its last two points, for DM_CURVE_POINTS: exponents above 0;
     0 for 1.
     */
    float opening_exponents[2];
    /* The same for the depth. */
    float controller_exponents[2];
} dm_joint_options;

/*
 A profile curve: where the composite of two fields is 0.5, at some depths of their contact. Points are pairs of field values
 from 0 to 1; every level has as many of them.
 */
typedef struct dm_profile {
    /* sizeof(dm_profile). */
    uint32_t size;
    /* DM_PROFILE_POLYLINE or DM_PROFILE_SPLINE: how the points of a surface are joined. */
    uint32_t form;
    /* Number of levels. */
    uint32_t levels;
    /* Control points of the surface at each level. */
    uint32_t surface_points;
    /* Points of the contact line at each level; 0 where nothing touches. */
    uint32_t contact_points;
    /* Depth of contact of each level, ascending from 0 to 1. */
    const double *depths;
    /* Surfaces, 2 numbers a point, level by level, each from (0, 0.5) to (0.5, 0). */
    const double *surfaces;
    /* Contact lines, 2 numbers a point, level by level, each from the surface inward; not read without points. */
    const double *contacts;
} dm_profile;

/* An ellipsoid that a joint carries and that swells with the bend of another, such as a muscle. */
typedef struct dm_primitive {
    /* sizeof(dm_primitive). */
    uint32_t size;
    /* Half its thickness in the middle, in units of the mesh. */
    float radius;
    /* Unique name, in UTF-8. */
    const char *name;
    /* Name of the joint that carries it. */
    const char *joint;
    /* Name of the joint whose bend swells it: the angle of its rotation against its parent since rest. */
    const char *driver;
    /* One end of its axis, from the joint's origin along the joint's axes, in units of the mesh. */
    float start[3];
    /* The other end. */
    float end[3];
    /* From the first bend to the second, rising from 0 to 180 degrees, it goes from the first scale to the second. */
    float degrees[2];
    /* Scales across its axis. */
    float scale[2];
    /* Scale along its axis at the second bend, from 1 at the first; 0 for 1. */
    float along;
} dm_primitive;

/*
 Receives how far a preparation is: the user pointer, what is being done, valid during the call only, and items done of all.

 Any thread may call it, one at a time. It must return: neither throw nor jump, and not call dermis. NULL for none.
 */
typedef void (*dm_progress)(void *user, const char *stage, uint64_t done, uint64_t total);

/*
 A chain of joints that bends by fleshing: the skin of a tail, trunk, neck or tentacle keeps the volume of every piece, and blends
 into the rest by its weights. It takes the place of one that the file marks at the same joint.
 */
typedef struct dm_spine_chain {
    /* sizeof(dm_spine_chain). */
    uint32_t size;
    /* DM_MAP_RADIAL, DM_MAP_NORMAL or DM_MAP_BINORMAL. */
    uint32_t map;
    /* Name of its first joint, in UTF-8. */
    const char *root;
    /* Name of its last joint, the first or a descendant. */
    const char *tip;
} dm_spine_chain;

/* How a character is prepared; dm_rig_options_default fills it. */
typedef struct dm_rig_options {
    /* sizeof(dm_rig_options). */
    uint32_t size;
    /* DM_RIG_HEAT_WEIGHTS or 0. */
    uint32_t flags;
    /* How often every triangle is cut into four, 0 to 4. */
    uint32_t subdivide;
    /* Magnitude of the bulge operator; 0 gives none, 1 is the authors' size and the default. */
    float magnitude;
    /* Number of joints. */
    uint32_t joint_count;
    /* Joints that have other than the defaults; may be NULL where there are none. */
    const struct dm_joint_options *joints;
    /* The profile curve of DM_OPERATOR_PROFILE; may be NULL. */
    const struct dm_profile *profile;
    /* Path of a profile curve as JSON, in place of profile; may be NULL. */
    const char *profile_file;
    /* Extra primitives (muscles); may be NULL where there are none. */
    const struct dm_primitive *primitives;
    /* Path of extra primitives as JSON, in place of primitives; may be NULL. */
    const char *primitive_file;
    /* Number of primitives. */
    uint32_t primitive_count;
    /* Number of parts. */
    uint32_t part_count;
    /* Joint whose part each vertex belongs to, one for each of dm_rig_info.vertices; NULL for that of its greatest weight. */
    const uint16_t *parts;
    /* Folder that keeps preparations, which then take milliseconds the next time; may be NULL. */
    const char *cache;
    /* Receives how far the preparation is; may be NULL. */
    dm_progress progress;
    /* First argument of progress. */
    void *progress_user;
    /* Chains of joints that bend by fleshing; may be NULL where there are none. */
    const struct dm_spine_chain *spines;
    /* Number of these. */
    uint32_t spine_count;
    /* 0. */
    uint32_t reserved;
} dm_rig_options;

/* A character, prepared once; immutable, and independent of contexts. Zero is no rig. */
typedef struct dm_rig {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_rig;

/*
 A rigged mesh, all in rest space: the space, in any unit, in which the mesh is modelled and bound.

 Rows at one position (seams of texture coordinates) are welded for the deformation and come back as the rows they are.
 */
typedef struct dm_mesh_desc {
    /* sizeof(dm_mesh_desc). */
    uint32_t size;
    /* Number of vertices. */
    uint32_t vertices;
    /* Number of triangles. */
    uint32_t triangles;
    /* Number of joints, up to 65535. */
    uint32_t joints;
    /* Joints and weights of each vertex, up to 64; not read without weights. */
    uint32_t influences;
    /* Positions, 3 numbers a vertex. */
    const float *positions;
    /* Normals, 3 numbers a vertex; NULL to compute them from the triangles. */
    const float *normals;
    /* Rows of vertices, 3 a triangle, counter-clockwise seen from outside. */
    const uint32_t *indices;
    /* Parent of each joint, UINT32_MAX for a root. Parents come before their children. */
    const uint32_t *parents;
    /* Bind matrix of each joint (the inverse of what glTF has): joint space to rest space, 16 numbers, column-major. */
    const float *bind;
    /* Name of each joint, unique, in UTF-8; NULL for joint_0, joint_1 and so on. */
    const char *const *names;
    /* Joints of each vertex, `influences` a vertex; NULL, as weights, to compute both by heat diffusion. */
    const uint16_t *joint_indices;
    /* Their weights, not negative; they are scaled to sum 1 where they do not. */
    const float *weights;
    /* How rigidly each vertex follows its joint in tracking, from 0 (free) to 1; NULL for 0. */
    const float *rigid;
} dm_mesh_desc;

/* Numbers of a rig. */
typedef struct dm_rig_info {
    /* sizeof(dm_rig_info), set by the caller. */
    uint32_t size;
    /* Rows of the output: the vertices of the file or the arrays, and those that subdivision adds. */
    uint32_t vertices;
    /* Vertices that are deformed, after rows at one position are welded. */
    uint32_t welded;
    /* Triangles, as rows of the output. */
    uint32_t triangles;
    /* Joints; a pose has a matrix each. */
    uint32_t joints;
    /* Implicit fields. */
    uint32_t fields;
    /* Animation clips of the file. */
    uint32_t clips;
} dm_rig_info;

/* A joint of a rig. */
typedef struct dm_joint_info {
    /* sizeof(dm_joint_info), set by the caller. */
    uint32_t size;
    /* Row of its parent, always smaller than its own; UINT32_MAX for a root. */
    uint32_t parent;
    /* Bind matrix: joint space to rest space, column-major. */
    float bind[16];
} dm_joint_info;

/* How a deformer works. Fill it by dm_settings_default and change what is to differ: zeros are no defaults. */
typedef struct dm_settings {
    /* sizeof(dm_settings). */
    uint32_t size;
    /* DM_LBS, DM_DQS, DM_IMPLICIT or DM_TRACKING. */
    uint32_t method;
    /* Share of the distance to the iso-value that a Newton step goes, above 0 to 1. */
    float sigma;
    /* Distance to the iso-value that counts as settled, in field values. */
    float tolerance;
    /* Angle between successive gradients that counts as a contact, degrees. */
    float contact_degrees;
    /* Newton steps before each relaxation, 1 to 64. */
    uint32_t steps;
    /* Rounds of Newton steps and relaxation, 1 to 256. */
    uint32_t rounds;
    /* Steps of the diffusion of contacts, 1 to 64. */
    uint32_t diffusions;
    /* Smoothing steps at contacts, odd, less than 64. */
    uint32_t smoothings;
    /* Newton steps of the last round and after the smoothing, 1 to 250. */
    uint32_t settling_steps;
    /* Tracking: iterations of a sub-step in which a joint turns by full_turn_degrees, least_iterations to 600. */
    uint32_t iterations;
    /* Tracking: least iterations of a sub-step, 1 or more. */
    uint32_t least_iterations;
    /* Tracking: turn of a joint that takes all iterations, degrees. */
    float full_turn_degrees;
    /* Tracking: movement in an iteration that counts as rest, over the radius of the vertex's part. */
    float stillness;
    /* Tracking: share of a vertex's goal that is where its joints carry it, 0 to 1. */
    float tie;
    /* Tracking: the same for open components and shells on a single part, 0 to 1. */
    float loose_tie;
    /* Tracking: spectral radius that Chebyshev's semi-iteration assumes, 0 (plain Jacobi) to less than 1. */
    float spectral_radius;
    /* Tracking: most degrees that a joint turns in a sub-step. */
    float substep_degrees;
    /* Tracking: bends below this count as this, degrees. */
    float least_bend_degrees;
    /* Tracking: most sub-steps a frame, 1 to 64. */
    uint32_t max_substeps;
    /* Tracking: sub-steps that turn further are looked over for faults and halved where they have any, degrees. */
    float halving_degrees;
    /* Tracking: faults more than at rest that do not matter. */
    uint32_t allowed_faults;
    /* Instances of the rig, 1 (or 0) to 65535: they share its fields, have a pose each, and are deformed together. */
    uint32_t instances;
} dm_settings;

/* One instance of a rig in a context, or several, which follow poses. Zero is no deformer. */
typedef struct dm_deformer {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_deformer;

/* Where dm_deformer_read puts a skin, a row a vertex of the output, in model space. Each array may be NULL. */
typedef struct dm_skin {
    /* sizeof(dm_skin). */
    uint32_t size;
    /* Vertices that each array has room for, at least dm_rig_info.vertices. */
    uint32_t vertices;
    /* Positions, 3 numbers a vertex. */
    float *positions;
    /* Unit normals, 3 numbers a vertex. */
    float *normals;
    /* Composed field at the vertex; 0 for geometric methods and vertices. */
    float *fields;
    /* Iso-value of the vertex; 0 for geometric methods and vertices. */
    float *isos;
    /*
     0 untouched, 1 on its iso-value, 2 stopped in contact, 3 outside every field, 4 iteration limit or, in tracking, on its way,
     5 past the limit of its spine's map.
     */
    uint8_t *states;
    /* Joint of the vertex's part. */
    uint16_t *bones;
    /* Instance to read, below dm_settings.instances. */
    uint32_t instance;
    /* 0. */
    uint32_t reserved;
} dm_skin;

/*
 How vertices lie in a buffer of the host's, and what reads them next. A vertex begins with its position, three 32-bit
 floats in model space; what is not named here stays as it is. Offsets and stride in bytes, multiples of 4.
 */
typedef struct dm_output_desc {
    /* sizeof(dm_output_desc). */
    uint32_t size;
    /* From vertex to vertex, at least 12. */
    uint32_t stride;
    /* VkBuffer of the context's device, made for storage use. */
    uint64_t buffer;
    /* Length of the buffer; dermis writes nothing behind it. */
    uint64_t bytes;
    /* Where the first vertex begins. */
    uint64_t offset;
    /* From a vertex's beginning to its normal, at least 12; 0 without normals. */
    uint32_t normal_offset;
    /* DM_NORMAL_NONE, DM_NORMAL_F32 or DM_NORMAL_SNORM8. */
    uint32_t normal_format;
    /* VkPipelineStageFlags that read the vertices next. */
    uint32_t stages;
    /* VkAccessFlags of these. */
    uint32_t access;
    /*
     Queue family that the buffer is released to after every frame, one of the device's or VK_QUEUE_FAMILY_EXTERNAL;
     DM_SAME_FAMILY for none. The host acquires it there, and before the next frame releases it there and acquires it for the
     context's family: what the frame does not write is lost otherwise.
     */
    uint32_t queue_family;
    /* 0. */
    uint32_t reserved;
    /* From the first vertex of an instance to that of the next; 0 where they follow each other, stride times vertices. */
    uint64_t instance_stride;
} dm_output_desc;

/* A buffer of the host's that frames of one deformer, or particles, are written into. Zero is no output. */
typedef struct dm_output {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_output;

/* How much work the last frame did. */
typedef struct dm_iterations {
    /* sizeof(dm_iterations), set by the caller. */
    uint32_t size;
    /* Most field evaluations of a vertex. */
    uint32_t newton_max;
    /* Mean field evaluations a vertex in reach of a field. */
    double newton_mean;
    /* Rounds of projection and relaxation. */
    uint32_t rounds;
    /* Jacobi iterations of all sub-steps (tracking). */
    uint32_t jacobi;
    /* Sub-steps of the frame. */
    uint32_t substeps;
    /* Sub-steps that were done again in two halves (tracking). */
    uint32_t halved;
    /* 1 where the frame would have needed more sub-steps than it may have (tracking), else 0. */
    uint32_t capped;
    /* Always 0. */
    uint32_t reserved;
    /* Field evaluations of all vertices. */
    uint64_t evaluations;
    /* Texture fetches of all vertices; 0 where they are not counted. */
    uint64_t fetches;
} dm_iterations;

/* How long the last frame took, in nanoseconds. */
typedef struct dm_timings {
    /* sizeof(dm_timings), set by the caller. */
    uint32_t size;
    /*
     1 where the times on the device are measured, else 0: without DM_CONTEXT_TIMESTAMPS, on the CPU, or before a frame
     is complete.
     */
    uint32_t measured;
    /* On the device, of the last frame that is complete, from its begin to its end; 0 where it is not measured. */
    uint64_t gpu_ns;
    /* What one timestamp costs, taken off gpu_ns; 0 where it is not measured. */
    uint64_t stamp_ns;
    /* On the CPU: what the last dm_deformer_advance took to record and submit, or on the CPU to compute. */
    uint64_t record_ns;
    /* Frames in a row of which each times some of the passes and all together every one; 0 where it is not measured. */
    uint32_t turns;
    /* Always 0. */
    uint32_t reserved;
} dm_timings;

/* When one pass of a frame ran, as dm_deformer_passes reports it. Text is valid during the call only. */
typedef struct dm_pass_timing {
    /* sizeof(dm_pass_timing), set by dermis. */
    uint32_t size;
    /* Steps that ran in this time, one after the other. */
    uint32_t steps;
    /* Name of the pass; "fill" and "copy" for transfers. */
    const char *name;
    /* Finer label of the first step; the name where it has none. */
    const char *label;
    /* Begin, nanoseconds on the device's clock. */
    uint64_t begin_ns;
    /* End, nanoseconds on the device's clock, without the timestamp that tells it. */
    uint64_t end_ns;
} dm_pass_timing;

/* Receives one pass of dm_deformer_passes: the user pointer and when it ran, valid during the call only. */
typedef void (*dm_pass_report)(void *user, const struct dm_pass_timing *pass);

/* A curve that meshes are bent along; immutable, and independent of contexts. Zero is no spine. */
typedef struct dm_spine {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_spine;

/* Points to be registered on a spine. */
typedef struct dm_flesh_desc {
    /* sizeof(dm_flesh_desc). */
    uint32_t size;
    /* DM_MAP_RADIAL, DM_MAP_NORMAL or DM_MAP_BINORMAL. */
    uint32_t map;
    /* Number of vertices. */
    uint32_t vertices;
    /* Zero. */
    uint32_t reserved;
    /* 3 numbers a vertex. */
    const float *positions;
    /* 3 numbers a vertex, of any length; NULL where normals are not wanted. */
    const float *normals;
} dm_flesh_desc;

/* Vertices registered on a spine, to be bent with it. Zero is none. */
typedef struct dm_flesh {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_flesh;

/* How registered vertices follow a bent spine. */
typedef struct dm_flesh_options {
    /* sizeof(dm_flesh_options). */
    uint32_t size;
    /* Not 0: the rest spine's length is fitted to the bent one's; 0: arc length is kept. */
    uint32_t stretch;
    /* From 0, plain skinning, to 1. */
    double strength;
    /* From 0, starts aligned, to 1, ends aligned. */
    double slide;
} dm_flesh_options;

/* Arrays that bent vertices are written to; those that are NULL are left out. */
typedef struct dm_bent {
    /* sizeof(dm_bent). */
    uint32_t size;
    /* Rows that each array has, as many as were registered. */
    uint32_t vertices;
    /* 3 numbers a vertex. */
    float *positions;
    /* 3 numbers a vertex, unit; NULL where no normals were registered. */
    float *normals;
    /* Distance to the nearest limit of the map, in units of the mesh: negative past it, infinite where both spines are straight. */
    float *distances;
    /* DM_FLESH_… a vertex. */
    uint32_t *flags;
} dm_bent;

/* What a spine is made of. Zeros are the defaults of all that a kind does not ask for. */
typedef struct dm_spine_desc {
    /* sizeof(dm_spine_desc). */
    uint32_t size;
    /* DM_SPINE_POLYNOMIAL, DM_SPINE_BSPLINE, DM_SPINE_POLYLINE, DM_SPINE_ARC or DM_SPINE_HELIX. */
    uint32_t kind;
    /* Number of points, of the first three kinds. */
    uint32_t point_count;
    /* Number of pairs in twist_profile. */
    uint32_t profile_count;
    /* 3 numbers a point; not read of arcs and helices. */
    const double *points;
    /* First point of an arc or helix. */
    double start[3];
    /* Direction there. */
    double tangent[3];
    /* From there to the centre or the axis; what it has along the tangent is left out. */
    double normal[3];
    /* Distance to the centre or the axis. */
    double radius;
    /* Length along an arc or helix. */
    double length;
    /* Rise of a turn of a helix along its axis; right-handed above 0. */
    double pitch;
    /*
     Where the first frame vector points at the start, as far as it is across the spine; zeros: as at the rest spine, turned the
     shortest way, or without one +z, or +y where the spine starts along z.
     */
    double up[3];
    /* Turn of the frame about the spine, degrees. */
    double twist_degrees;
    /* More of it along the spine: pairs of a rising share of the length, 0 to 1, and degrees; not read without. */
    const double *twist_profile;
    /*
     How far past either end curvature takes to ease to zero, as a share of the length, up to 1/8, which 0 stands for; below 0
     the spine is straight from its ends on.
     */
    double ease;
} dm_spine_desc;

/* Numbers of a spine. */
typedef struct dm_spine_info {
    /* sizeof(dm_spine_info), set by the caller. */
    uint32_t size;
    /* 1 where the end is the start. */
    uint32_t closed;
    /* Arc length. */
    double length;
} dm_spine_info;

/* A spine at one arc length. */
typedef struct dm_spine_section {
    /* sizeof(dm_spine_section), set by the caller. */
    uint32_t size;
    /* Zero. */
    uint32_t reserved;
    /* Point on the curve. */
    double position[3];
    /* Unit tangent. */
    double tangent[3];
    /* First frame vector, across the tangent. */
    double side[3];
    /* Second frame vector, tangent × side. */
    double lift[3];
    /* Curvature vector, to the centre of curvature, along side and lift. */
    double curvature[2];
} dm_spine_section;

/* How a sphere-mesh is built; dm_sphere_mesh_options_default fills it. */
typedef struct dm_sphere_mesh_options {
    /* sizeof(dm_sphere_mesh_options). */
    uint32_t size;
    /* DM_SPHERE_MESH_ALLOW_INVERSION or 0. */
    uint32_t flags;
    /*
     How much curved places count, 0 to 1: the power of 1 + BBD^2 (k1^2 + k2^2) with which areas are weighted; at 0 area
     alone counts.
     */
    double curvature;
    /* Weight of temporal coherence against the planes', 0 to 1e9: from about 1 on spheres stay near the middle of their region. */
    double temporal;
    /* Receives how far the build is; may be NULL. */
    dm_progress progress;
    /* First argument of progress. */
    void *progress_user;
} dm_sphere_mesh_options;

/* The same mesh at several moments, in any unit. */
typedef struct dm_sequence_desc {
    /* sizeof(dm_sequence_desc). */
    uint32_t size;
    /* Number of vertices. */
    uint32_t vertices;
    /* Number of triangles. */
    uint32_t triangles;
    /* Number of frames. */
    uint32_t frames;
    /* 3 numbers a vertex, frame by frame. */
    const float *positions;
    /* Rows of vertices, 3 a triangle, counter-clockwise seen from outside, the same in all frames. */
    const uint32_t *indices;
} dm_sequence_desc;

/* A sphere-mesh with all its levels; immutable, and independent of contexts. Zero is none. */
typedef struct dm_sphere_mesh {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_sphere_mesh;

/* Numbers of a sphere-mesh. */
typedef struct dm_sphere_mesh_info {
    /* sizeof(dm_sphere_mesh_info), set by the caller. */
    uint32_t size;
    /* Frames. */
    uint32_t frames;
    /* Vertices after rows that coincide in all frames are welded: the most spheres that a level can have. */
    uint32_t vertices;
    /* Triangles between them. */
    uint32_t triangles;
    /* The least spheres that a level can have: one a connected component. */
    uint32_t least_spheres;
    /* Zero. */
    uint32_t reserved;
    /* Mean over the frames of the bounding box's diagonal. */
    double diagonal;
} dm_sphere_mesh_info;

/* A level of a sphere-mesh; immutable, and independent of contexts. Zero is none. */
typedef struct dm_level {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_level;

/* Numbers of a level. */
typedef struct dm_level_info {
    /* sizeof(dm_level_info), set by the caller. */
    uint32_t size;
    /* Frames. */
    uint32_t frames;
    /* Spheres. */
    uint32_t spheres;
    /* Edges that no triangle has: capsules. */
    uint32_t edges;
    /* Triangles: thick triangles. */
    uint32_t triangles;
    /* Zero. */
    uint32_t reserved;
    /* Root of the mean square distance between the planes of the mesh and the spheres, % of the diagonal. */
    double error;
} dm_level_info;

/* Arrays that a level at one time is written to; those that are NULL are left out. */
typedef struct dm_spheres {
    /* sizeof(dm_spheres). */
    uint32_t size;
    /* Rows that centres and radii have, dm_level_info.spheres. */
    uint32_t spheres;
    /* Rows that edge_ends has, dm_level_info.edges. */
    uint32_t edges;
    /* Rows that corners has, dm_level_info.triangles. */
    uint32_t triangles;
    /* Time in frames: between two of them centres go straight, before the first and behind the last they stay. */
    double time;
    /* 3 numbers a sphere, in the sequence's units. */
    float *centres;
    /* 1 number a sphere, in the sequence's units; the same at all times. */
    float *radii;
    /* 2 spheres an edge, along which they are interpolated. */
    uint32_t *edge_ends;
    /* 3 spheres a triangle. */
    uint32_t *corners;
} dm_spheres;

/* A level at one time, ready for collisions; immutable, and independent of contexts. Zero is none. */
typedef struct dm_collider {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_collider;

/* Spheres that move along segments, in the units of the sphere-mesh, and where they first touch. */
typedef struct dm_sweeps {
    /* sizeof(dm_sweeps). */
    uint32_t size;
    /* Number of spheres. */
    uint32_t count;
    /* 7 numbers a sphere: where its centre begins, where it ends, and its radius, 0 or more. */
    const double *segments;
    /*
     7 numbers a sphere: the time of the first touch, 0 at the beginning of the segment to 1 at its end; where its centre is then;
     the outward unit normal of the sphere-mesh where they touch. Without a touch: infinity, the end of the segment, zeros.
     */
    double *hits;
    /* DM_HIT_NONE, DM_HIT_TOUCHED or DM_HIT_PUSHED of each; may be NULL. */
    uint32_t *states;
} dm_sweeps;

/* How particles fly and bounce; dm_particle_settings_default fills it. */
typedef struct dm_particle_settings {
    /* sizeof(dm_particle_settings). */
    uint32_t size;
    /* Contacts of a particle in a frame, 1 to 64; after the last it stays with the surface until the frame ends. */
    uint32_t contacts;
    /* Acceleration of all particles, units a second squared. */
    float gravity[3];
    /* Share of the normal speed that a bounce leaves, 0 to 1. */
    float restitution;
    /* Coulomb's coefficient of friction, 0 or more. */
    float friction;
    /* 0. */
    uint32_t reserved;
} dm_particle_settings;

/* Particles, in the units of the sphere-mesh and in seconds. */
typedef struct dm_particles_desc {
    /* sizeof(dm_particles_desc). */
    uint32_t size;
    /* Number of particles. */
    uint32_t count;
    /* 4 numbers a particle: its centre and its radius, 0 or more. */
    const float *positions;
    /* 3 numbers a particle, units a second; NULL where all rest. */
    const float *velocities;
} dm_particles_desc;

/* Particles in a context, and the level that they bounce off. Zero is none. */
typedef struct dm_particles {
    /* Number of the handle; it never names another object in the life of the process. */
    uint64_t id;
} dm_particles;

/* Arrays that particles are written to; those that are NULL are left out. */
typedef struct dm_flights {
    /* sizeof(dm_flights). */
    uint32_t size;
    /* Rows that each array has, as many as there are particles. */
    uint32_t count;
    /* 4 numbers a particle: its centre and its radius. */
    float *positions;
    /* 3 numbers a particle, units a second. */
    float *velocities;
    /* How often each has touched the level so far, and been pushed out of it. */
    uint32_t *contacts;
} dm_flights;

#ifdef __cplusplus
extern "C" {
#endif  /* __cplusplus */

/*
 Version of the interface that the library has: DM_API_VERSION of its own header.

 Threads: any, at any time.
 */
uint32_t dm_api_version(void);

/*
 Message of the last call of this thread that failed, in English and UTF-8; "" where none has failed. Never NULL.

 It names the function, the argument and the reason. The text belongs to dermis and stays valid until this thread calls
 another function of dermis or ends.
 */
const char *dm_last_error(void);

/*
 Opens a device of dermis' own: Vulkan instance, device, queue and memory belong to dermis.

 desc: copied; its text may go after the call. out: receives the handle, which is the caller's to destroy.

 Threads: any. Takes from milliseconds to a second.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_VERSION where api_version is not the library's;
 DM_ERROR_ARGUMENT for unknown flags or text that is not UTF-8; DM_ERROR_NO_DEVICE without a loader, a device that fits or
 the validation layers, with what to install; DM_ERROR_VULKAN, DM_ERROR_MEMORY or DM_ERROR_DEVICE_LOST where the driver fails.

 Pointers:
 desc and out are NULL or valid; device is NULL or text that ends with zero; log and log_user stay valid as long as the
 context and its deformers, and log may be called by any thread that calls dermis.
 */
dm_result dm_context_create(const struct dm_context_desc *desc,
                            struct dm_context *out);

/*
 Destroys a context. Deformers in it stay usable and keep its device until they are destroyed, too.

 Threads: any; a call that uses the context on another thread completes first or keeps it until its end.
 May wait for the device.

 Returns DM_OK, or DM_ERROR_HANDLE where there is no such context (any more).
 */
dm_result dm_context_destroy(struct dm_context context);

/*
 Sums the device memory that a context has in use.

 out: size set by the caller, the rest is filled.

 Threads: any. Does not wait for the device.

 Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE, DM_ERROR_HANDLE, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_context_memory(struct dm_context context, struct dm_memory *out);

/*
 Reports every buffer and image that a context has in use, in the order in which they were made; none on the CPU.

 report: called once each with user, during this call and on this thread; no object is locked meanwhile, so that it may
 call dermis. It must return: neither throw nor jump.

 Threads: any. Does not wait for the device.

 Returns DM_OK, DM_ERROR_NULL where report is, DM_ERROR_HANDLE, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.

 Pointers:
 report is NULL or a function that may be called with user.
 */
dm_result dm_context_allocations(struct dm_context context,
                                 dm_allocation_report report,
                                 void *user);

/*
 Reports every device that a context can be made on, in Vulkan's order.

 report: called once each with user, during this call and on this thread; it may call dermis. It must return: neither throw
 nor jump.

 Threads: any. Takes milliseconds.

 Returns DM_OK; DM_ERROR_NULL where report is; DM_ERROR_NO_DEVICE without a loader or a device that fits; DM_ERROR_VULKAN or
 DM_ERROR_MEMORY where the driver fails.

 Pointers:
 report is NULL or a function that may be called with user.
 */
dm_result dm_devices(dm_device_report report,
                     void *user);

/*
 Asks what dermis can make use of on a device, before the host creates it. Creates nothing.

 get_instance_proc_addr, instance (VkInstance), physical_device (VkPhysicalDevice): the host's.
 out: size set by the caller, the rest is filled.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_NO_DEVICE where the device is older than Vulkan 1.2 or has
 no queue that does compute; DM_ERROR_VULKAN; DM_ERROR_MEMORY.

 Pointers:
 The handles are NULL or valid; out is NULL or valid.
 */
dm_result dm_vulkan_get_requirements(dm_get_instance_proc_addr get_instance_proc_addr,
                                     void *instance,
                                     void *physical_device,
                                     struct dm_vulkan_requirements *out);

/*
 Makes a context on a device of the host's, which keeps all of it.

 desc: copied. out: receives the handle, which is the caller's to destroy, with all deformers and outputs in it before the
 device.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_VERSION where api_version is not the library's;
 DM_ERROR_ARGUMENT for features that are unknown or not on, or a queue family that does no compute; DM_ERROR_NO_DEVICE below Vulkan 1.2;
 DM_ERROR_VULKAN or DM_ERROR_MEMORY where the driver fails.

 Pointers:
 desc and out are NULL or valid; the Vulkan handles are NULL or valid, and stay so until the context and all that was made
 in it are destroyed; log and log_user stay valid as long, and log may be called by any thread that calls dermis.
 */
dm_result dm_context_adopt(const struct dm_vulkan_desc *desc,
                           struct dm_context *out);

/*
 Fills options with the defaults, those that NULL in their place has.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_rig_options_default(struct dm_rig_options *out);

/*
 Reads a rigged character from a glTF 2.0 file (.glb, .gltf) and prepares it: fits the implicit fields, once.

 path: UTF-8. options: NULL for the defaults; copied. out: receives the handle, which is the caller's to destroy.

 Threads: any; works on all cores, from a tenth of a second to some seconds.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_FILE where a file cannot be read or used, naming the element;
 DM_ERROR_ARGUMENT for options that are out of range or name joints which the character has not.

 Pointers:
 path is NULL or text that ends with zero; options is NULL or valid with all it points to; out is NULL or valid.
 */
dm_result dm_rig_load(const char *path,
                      const struct dm_rig_options *options,
                      struct dm_rig *out);

/*
 Prepares a character from arrays in memory, without a file; it has no clips.

 desc: all its arrays are copied. options: NULL for the defaults; copied. out: receives the handle, which is the caller's
 to destroy.

 Threads: any; works on all cores, from a tenth of a second to some seconds.

 Returns DM_OK; DM_ERROR_NULL where an array is that must not be; DM_ERROR_STRUCT_SIZE; DM_ERROR_ARGUMENT naming the array
 and the row that is not finite or out of range, the joint without inverse or before its parent, or what is wrong with the
 options; DM_ERROR_FILE for files that the options name.

 Pointers:
 desc and options are NULL or valid with all they point to, each array as long as desc says; out is NULL or valid.
 */
dm_result dm_rig_create(const struct dm_mesh_desc *desc,
                        const struct dm_rig_options *options,
                        struct dm_rig *out);

/*
 Destroys a rig. Deformers of it stay usable.

 Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such rig (any more).
 */
dm_result dm_rig_destroy(struct dm_rig rig);

/*
 Tells the numbers of a rig.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_rig_get_info(struct dm_rig rig, struct dm_rig_info *out);

/*
 Finds a joint by its name.

 name: UTF-8. out: receives the joint's row, that of its matrix in a pose.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the rig has no such joint.

 Pointers:
 name is NULL or text that ends with zero; out is NULL or valid.
 */
dm_result dm_rig_joint(struct dm_rig rig,
                       const char *name,
                       uint32_t *out);

/*
 Tells the name of a joint, in UTF-8.

 out: receives the text with its zero byte; bytes: room in it. needed: receives the bytes that the text takes; may be NULL.
 With out NULL and bytes 0 only needed is written.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a row that the rig has not;
 DM_ERROR_SIZE where there is not enough room, with needed written.

 Pointers:
 out is NULL or has room for bytes; needed is NULL or valid.
 */
dm_result dm_rig_joint_name(struct dm_rig rig,
                            uint32_t joint,
                            char *out,
                            size_t bytes,
                            size_t *needed);

/*
 Copies the triangles, 3 rows of the output each.

 out: array of the caller; count: numbers that it has room for, at least three times dm_rig_info.triangles.

 Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_HANDLE or DM_ERROR_SIZE.

 Pointers:
 out is NULL or has room for count numbers.
 */
dm_result dm_rig_indices(struct dm_rig rig, uint32_t *out, size_t count);

/*
 Tells the time of a clip's last key, in seconds.

 clip: row of the clip, less than dm_rig_info.clips.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a clip that the rig has not.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_rig_clip_seconds(struct dm_rig rig,
                              uint32_t clip,
                              float *out);

/*
 Samples a clip of the file; before its first and after its last key it holds.

 seconds: time in the clip. matrices: array of the caller, 16 numbers a joint, column-major: each carries rest space to
 model space, which is the space of the file's scene. count: matrices that it has room for, at least dm_rig_info.joints.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_ARGUMENT for a clip that the rig has
 not or a time that is not finite; DM_ERROR_POSE where the file's keys give no usable pose.

 Pointers:
 matrices is NULL or has room for 16 times count numbers.
 */
dm_result dm_rig_pose_clip(struct dm_rig rig,
                           uint32_t clip,
                           float seconds,
                           float *matrices,
                           size_t count);

/*
 Composes a pose of turns: each joint moves in its own frame, as it is bound, and carries its children.

 local: 16 numbers a joint, column-major, identities for rest. matrices: array of the caller, 16 numbers a joint,
 column-major: each carries rest space to model space, which here is rest space as well; may be the same array as local.
 count: matrices in either, exactly dm_rig_info.joints.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_POSE naming the joint whose matrix is
 not finite, not affine or has no inverse.

 Pointers:
 local is NULL or has 16 times count numbers; matrices is NULL or has room for as many.
 */
dm_result dm_rig_pose_local(struct dm_rig rig,
                            const float *local,
                            float *matrices,
                            size_t count);

/*
 Tells parent and bind matrix of a joint. A pose's matrix of the joint is where it is now times the inverse of this.

 joint: row of the joint, less than dm_rig_info.joints. out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a row that the rig
 has not.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_rig_joint_info(struct dm_rig rig,
                            uint32_t joint,
                            struct dm_joint_info *out);

/*
 Tells the name of a clip, in UTF-8.

 clip: row of the clip, less than dm_rig_info.clips. out, bytes and needed: as in dm_rig_joint_name.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a clip that the rig has not;
 DM_ERROR_SIZE where there is not enough room, with needed written.

 Pointers:
 out is NULL or has room for bytes; needed is NULL or valid.
 */
dm_result dm_rig_clip_name(struct dm_rig rig,
                           uint32_t clip,
                           char *out,
                           size_t bytes,
                           size_t *needed);

/*
 Goes from one pose to another: every joint turns along the shortest arc in its parent's frame, its place and scale change
 evenly.

 a, b: poses as dm_deformer_advance takes them, 16 numbers a joint. t: from 0, which gives a, to 1, which gives b.
 matrices: array of the caller, as long; may be the same array as a or b. count: matrices in each, exactly
 dm_rig_info.joints.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_POSE naming the joint whose matrix is
 not finite, not affine or has no inverse; DM_ERROR_ARGUMENT for a t out of its range.

 Pointers:
 a and b are NULL or have 16 times count numbers; matrices is NULL or has room for as many.
 */
dm_result dm_rig_pose_interpolate(struct dm_rig rig,
                                  const float *a,
                                  const float *b,
                                  float t,
                                  float *matrices,
                                  size_t count);

/*
 Makes one instance of a rig in a context, or several (dm_settings.instances), at rest: uploads it and samples its fields on the device.

 settings: NULL for the defaults; copied. out: receives the handle, which is the caller's to destroy. The deformer keeps
 what it needs of context and rig, which may be destroyed before it. What was mended in the character is told to the
 context's log.

 Threads: any; other calls on the context wait meanwhile. Takes from milliseconds to a second, and waits for the device.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the setting that is out of
 range, or where the rig has what the method cannot do; DM_ERROR_MEMORY where the budget or the device is too small;
 DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 settings and out are NULL or valid.
 */
dm_result dm_deformer_create(struct dm_context context,
                             struct dm_rig rig,
                             const struct dm_settings *settings,
                             struct dm_deformer *out);

/*
 Destroys a deformer.

 Threads: any; a call that uses it on another thread completes first. Does not wait for the device: memory goes when the
 device is done with it.

 Returns DM_OK, or DM_ERROR_HANDLE where there is no such deformer (any more).
 */
dm_result dm_deformer_destroy(struct dm_deformer deformer);

/*
 Deforms all instances, each for its pose. Submits to the context's queue and does not wait, unless two frames are on their way already; on the
 CPU it computes.

 matrices: 16 numbers a joint, column-major: each carries rest space to model space, identities for rest; copied. The joints
 of the first instance, then those of the second.
 count: matrices, exactly dm_rig_info.joints times dm_settings.instances.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_POSE naming the joint whose matrix is not finite,
 not affine or has no inverse; DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC. Where it is not DM_OK
 all skins are as they were.

 Pointers:
 matrices is NULL or has 16 times count numbers.
 */
dm_result dm_deformer_advance(struct dm_deformer deformer,
                              const float *matrices,
                              size_t count);

/*
 Waits until the last pose is deformed.

 Threads: any.

 Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_VULKAN, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.
 */
dm_result dm_deformer_wait(struct dm_deformer deformer);

/*
 Reads the last skin of an instance; waits for it. Before the first pose its content is undefined.

 skin: where to put it; the arrays are the caller's.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE; DM_ERROR_ARGUMENT for an instance that
 does not exist; DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 skin is NULL or valid, and each array in it is NULL or has room for as many vertices as it says.
 */
dm_result dm_deformer_read(struct dm_deformer deformer,
                           const struct dm_skin *skin);

/*
 Forgets the tracked skins of all instances: the next poses are reached from rest, whatever came before. For cuts. Does nothing
 for methods other than tracking, which have no such state.

 Threads: any. Waits for the device.

 Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_VULKAN, DM_ERROR_MEMORY, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC. Where Vulkan or
 memory failed there is no state any more: poses are refused by DM_ERROR_ARGUMENT until this or dm_deformer_restore succeeds.
 */
dm_result dm_deformer_reset(struct dm_deformer deformer);

/*
 The same for one instance.

 instance: below dm_settings.instances.

 Threads: any. Waits for the device.

 Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_ARGUMENT for an instance that does not exist, DM_ERROR_VULKAN, DM_ERROR_DEVICE_LOST
 or DM_ERROR_PANIC.
 */
dm_result dm_deformer_reset_instance(struct dm_deformer deformer,
                                     uint32_t instance);

/*
 Saves the state that the next frame of the first instance goes on from, as bytes for dm_deformer_restore of the same rig and
 settings, by this version of the library on this kind of machine. 0 bytes for methods other than tracking.

 out: buffer of the caller; bytes: room in it. needed: receives the bytes of the state; may be NULL.
 With out NULL and bytes 0 only needed is written. The number grows once, with the first pose.

 Threads: any. Waits for the device.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_SIZE where there is not enough room, with needed written;
 DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 out is NULL or has room for bytes; needed is NULL or valid.
 */
dm_result dm_deformer_save(struct dm_deformer deformer,
                           void *out,
                           size_t bytes,
                           size_t *needed);

/*
 The same for any instance.

 instance: below dm_settings.instances. out, bytes, needed: as in dm_deformer_save.

 Threads: any. Waits for the device.

 Returns what dm_deformer_save does; DM_ERROR_ARGUMENT for an instance that does not exist.

 Pointers:
 As in dm_deformer_save.
 */
dm_result dm_deformer_save_instance(struct dm_deformer deformer,
                                    uint32_t instance,
                                    void *out,
                                    size_t bytes,
                                    size_t *needed);

/*
 Lets the first instance go on from a saved state.

 state: what dm_deformer_save wrote; copied. bytes: its length; 0, with state NULL or not, for methods that have no state.

 Threads: any. Waits for the device.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the bytes are no state, or one of another
 character, or the method has none; DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC. Where Vulkan or
 memory failed there is no state any more, as after dm_deformer_reset.

 Pointers:
 state is NULL or has bytes.
 */
dm_result dm_deformer_restore(struct dm_deformer deformer,
                              const void *state,
                              size_t bytes);

/*
 The same for any instance, from a state of any.

 instance: below dm_settings.instances. state, bytes: as in dm_deformer_restore.

 Threads: any. Waits for the device.

 Returns what dm_deformer_restore does; DM_ERROR_ARGUMENT for an instance that does not exist.

 Pointers:
 As in dm_deformer_restore.
 */
dm_result dm_deformer_restore_instance(struct dm_deformer deformer,
                                       uint32_t instance,
                                       const void *state,
                                       size_t bytes);

/*
 Makes a buffer of the host's an output of a deformer: dm_frame_record writes one vertex for each of dm_rig_info.vertices, of
 every instance.

 context: the deformer's, made by dm_context_adopt or of the same device. desc: copied; the buffer stays the host's.
 out: receives the handle, which is the caller's to destroy before the buffer.

 Threads: any. Submits nothing.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the deformer is of another
 context; DM_ERROR_ARGUMENT where the vertices do not fit, for a queue family that the device has not, or on the CPU;
 DM_ERROR_MEMORY for a buffer longer than a shader can bind; DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 desc and out are NULL or valid; the buffer is valid and as long as desc says until the output is destroyed.
 */
dm_result dm_output_create(struct dm_context context,
                           struct dm_deformer deformer,
                           const struct dm_output_desc *desc,
                           struct dm_output *out);

/*
 Destroys an output; the buffer stays as it is. The commands that were recorded with it have to be done.

 Threads: any; a call that uses it on another thread completes first.

 Returns DM_OK, or DM_ERROR_HANDLE where there is no such output (any more).
 */
dm_result dm_output_destroy(struct dm_output output);

/*
 Records a frame into a command buffer of the host's: what dm_deformer_advance submits, and the writing of the output.
 Submits nothing, waits for nothing, allocates nothing.

 State before: the command buffer (VkCommandBuffer), a primary one, is being recorded, outside of a render pass and of
 queries, for the family of the context's queue. Whatever was submitted to the queue before comes first, by a barrier. State
 after: secondary command buffers have been executed, so that no pipeline, descriptor set or other state is bound any more;
 the output's vertices are visible to the stages and accesses of its description, or released to its queue family.

 The host submits the command buffer to the context's queue, once, and poses in the order of their recording.

 matrices, count: as in dm_deformer_advance, the poses of all instances. output: of this deformer, or zero for none.
 frame_slot: below DM_FRAME_SLOTS; what was recorded with it before has to be done, since its pose is overwritten.

 Threads: any that may record into the command buffer.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the output is of another deformer; DM_ERROR_SIZE;
 DM_ERROR_POSE; DM_ERROR_ARGUMENT for the slot, or on the CPU; DM_ERROR_DEVICE_LOST where another call has found it;
 DM_ERROR_PANIC. Where it is not DM_OK nothing is recorded.

 Pointers:
 The command buffer is NULL or in the state above; deformer and output are not destroyed before it is done; matrices is
 NULL or has 16 times count numbers.
 */
dm_result dm_frame_record(struct dm_deformer deformer,
                          void *command_buffer,
                          uint32_t frame_slot,
                          const float *matrices,
                          size_t count,
                          struct dm_output output);

/*
 Tells how much work the last frame did, for all instances together; all zero for geometric methods.

 out: size set by the caller, the rest is filled.

 Threads: any. Waits for the frame.

 Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE, DM_ERROR_HANDLE, DM_ERROR_VULKAN, DM_ERROR_MEMORY,
 DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_deformer_iterations(struct dm_deformer deformer, struct dm_iterations *out);

/*
 Tells how long the last frame took.

 out: size set by the caller, the rest is filled.

 Threads: any. Does not wait for the device.

 Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE, DM_ERROR_HANDLE, DM_ERROR_DEVICE_LOST or DM_ERROR_PANIC.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_deformer_timings(struct dm_deformer deformer, struct dm_timings *out);

/*
 Reports when the passes of the last frame that is complete ran on the device, in their order; none where times are not
 measured. Each frame times some of the passes, so that timing costs little: dm_timings.turns frames in a row have them all.

 report: called once each with user, during this call and on this thread; no object is locked meanwhile, so that it may
 call dermis. It must return: neither throw nor jump.

 Threads: any. Does not wait for the device.

 Returns DM_OK, DM_ERROR_NULL where report is, DM_ERROR_HANDLE or DM_ERROR_PANIC.

 Pointers:
 report is NULL or a function that may be called with user.
 */
dm_result dm_deformer_passes(struct dm_deformer deformer,
                             dm_pass_report report,
                             void *user);

/*
 Fills settings with the defaults, those that NULL in their place has: the papers', or what measured best.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_settings_default(struct dm_settings *out);

/*
 Registers vertices on a rest spine, once for all ways to bend it.

 desc: copied with its arrays. out: receives the handle, which is the caller's to destroy.

 Threads: any; works on all cores.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the row that is not finite, or
 the member that is out of range.

 Pointers:
 desc is NULL or valid with its arrays, each as long as it says; out is NULL or valid.
 */
dm_result dm_flesh_create(struct dm_spine rest,
                          const struct dm_flesh_desc *desc,
                          struct dm_flesh *out);

/*
 Destroys registered vertices.

 Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there are no such (any more).
 */
dm_result dm_flesh_destroy(struct dm_flesh flesh);

/*
 Bends registered vertices to another spine.

 options: NULL for full strength, no slide and no stretch. out: its arrays are filled.

 Threads: any; works on all cores. Allocates at the first call only.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE where out has another number of rows;
 DM_ERROR_ARGUMENT for options out of range, normals where none were registered, or closed spines that do not fit.

 Pointers:
 options is NULL or valid; out is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
 */
dm_result dm_flesh_bend(struct dm_flesh flesh,
                        struct dm_spine bent,
                        const struct dm_flesh_options *options,
                        const struct dm_bent *out);

/*
 Prepares a spine.

 desc: copied with its arrays. rest: the spine that this one is a bend of, from which it takes its frame where desc has no up;
 zero for none. out: receives the handle, which is the caller's to destroy.

 Threads: any; takes up to some milliseconds.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming what is not finite, has no length
 or no direction, or is out of range.

 Pointers:
 desc is NULL or valid with its arrays, each as long as its numbers say; out is NULL or valid.
 */
dm_result dm_spine_create(const struct dm_spine_desc *desc,
                          struct dm_spine rest,
                          struct dm_spine *out);

/*
 Reads a spine from a JSON file, as `dermis flesh` does, and prepares it.

 path: UTF-8. rest: as for dm_spine_create. out: receives the handle, which is the caller's to destroy.

 Threads: any; takes up to some milliseconds.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where path is not UTF-8; DM_ERROR_FILE naming the file and the
 key that is unknown, missing or wrong.

 Pointers:
 path is NULL or text that ends with zero; out is NULL or valid.
 */
dm_result dm_spine_load(const char *path,
                        struct dm_spine rest,
                        struct dm_spine *out);

/*
 Destroys a spine. What was registered on it stays usable.

 Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such spine (any more).
 */
dm_result dm_spine_destroy(struct dm_spine spine);

/*
 Tells the numbers of a spine.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_spine_get_info(struct dm_spine spine, struct dm_spine_info *out);

/*
 Tells point, frame and curvature of a spine at an arc length, which may lie past its ends.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the arc length is not
 finite.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_spine_at(struct dm_spine spine,
                      double arc_length,
                      struct dm_spine_section *out);

/*
 Fills options with the defaults, those that NULL in their place has.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_sphere_mesh_options_default(struct dm_sphere_mesh_options *out);

/*
 Builds the sphere-mesh of a sequence: all levels, from one sphere a vertex to one a connected component.

 desc: copied with its arrays. options: NULL for the defaults. out: receives the handle, which is the caller's to destroy.

 Threads: any; works on all cores, about a microsecond a vertex and frame.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_ARGUMENT naming the frame, vertex or triangle that cannot be used,
 or the option that is out of range; DM_ERROR_MEMORY where the build needs more than there is, before it begins.

 Pointers:
 desc is NULL or valid with its arrays, each as long as its numbers say; options is NULL or valid, and its progress may be
 called by any thread, one at a time, until the call returns; out is NULL or valid.
 */
dm_result dm_sphere_mesh_build(const struct dm_sequence_desc *desc,
                               const struct dm_sphere_mesh_options *options,
                               struct dm_sphere_mesh *out);

/*
 Reads a sphere-mesh from a file (.dsm) that dm_sphere_mesh_save or `dermis sphere-mesh build` wrote.

 path: UTF-8. out: receives the handle, which is the caller's to destroy.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_ARGUMENT where path is not UTF-8; DM_ERROR_FILE where the file cannot be read, is none of
 these or is damaged.

 Pointers:
 path is NULL or text that ends with zero; out is NULL or valid.
 */
dm_result dm_sphere_mesh_load(const char *path,
                              struct dm_sphere_mesh *out);

/*
 Writes a sphere-mesh with all its levels to a file (.dsm). A file that is there is replaced once the new one is whole.

 path: UTF-8.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where path is not UTF-8; DM_ERROR_FILE where it cannot be
 written.

 Pointers:
 path is NULL or text that ends with zero.
 */
dm_result dm_sphere_mesh_save(struct dm_sphere_mesh mesh,
                              const char *path);

/*
 Destroys a sphere-mesh. Its levels stay usable.

 Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such sphere-mesh (any more).
 */
dm_result dm_sphere_mesh_destroy(struct dm_sphere_mesh mesh);

/*
 Tells the numbers of a sphere-mesh.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_sphere_mesh_get_info(struct dm_sphere_mesh mesh, struct dm_sphere_mesh_info *out);

/*
 Tells the least number of spheres whose error is at most this.

 error: as dm_level_info.error, % of the diagonal. out: receives the number.

 Threads: any. Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the error is negative or no number.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_sphere_mesh_spheres_for(struct dm_sphere_mesh mesh,
                                     double error,
                                     uint32_t *out);

/*
 Opens the level of a sphere-mesh with this many spheres.

 spheres: from dm_sphere_mesh_info.least_spheres to dm_sphere_mesh_info.vertices. flags: DM_LEVEL_PLAIN, or 0, by which every
 vertex goes to the nearest of its sphere and that sphere's neighbours, which are joined anew. out: receives the handle, which is
 the caller's to destroy.

 Threads: any; works on all cores.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for unknown flags, or naming the range where there is no such
 level.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_level_create(struct dm_sphere_mesh mesh,
                          uint32_t spheres,
                          uint32_t flags,
                          struct dm_level *out);

/*
 Destroys a level. Colliders and particles that were made with it stay usable.

 Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such level (any more).
 */
dm_result dm_level_destroy(struct dm_level level);

/*
 Tells the numbers of a level.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL, DM_ERROR_STRUCT_SIZE or DM_ERROR_HANDLE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_level_get_info(struct dm_level level, struct dm_level_info *out);

/*
 Reads the spheres of a level at a time, with its edges and triangles.

 spheres: its arrays are filled.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE where the arrays have other numbers of rows than
 dm_level_info says; DM_ERROR_ARGUMENT where the time is not finite.

 Pointers:
 spheres is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
 */
dm_result dm_level_read(struct dm_level level,
                        const struct dm_spheres *spheres);

/*
 Prepares a level at a time for collisions with its spheres, capsules and thick triangles.

 time: in frames, as dm_spheres.time. out: receives the handle, which is the caller's to destroy.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT where the time is not finite.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_collider_create(struct dm_level level, double time, struct dm_collider *out);

/*
 Destroys a collider.

 Threads: any. Returns DM_OK, or DM_ERROR_HANDLE where there is no such collider (any more).
 */
dm_result dm_collider_destroy(struct dm_collider collider);

/*
 Tells where moving spheres first touch, in closed form and double precision: nothing tunnels through, however fast.

 One that begins inside is pushed out along the normal of a primitive that holds it, at time 0. One that begins on the surface
 touches at time 0 if it moves inwards, and is free if it moves outwards: what has bounced goes on.

 sweeps: its arrays hits and states are filled.

 Threads: any; works on all cores.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the row that is not finite, is beyond
 1e60 or has a negative radius, or for too many of them.

 Pointers:
 sweeps is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
 */
dm_result dm_collider_sweep(struct dm_collider collider,
                            const struct dm_sweeps *sweeps);

/*
 Fills settings with the defaults, those that NULL in their place has.

 out: size set by the caller, the rest is filled.

 Threads: any. Returns DM_OK, DM_ERROR_NULL or DM_ERROR_STRUCT_SIZE.

 Pointers:
 out is NULL or valid.
 */
dm_result dm_particle_settings_default(struct dm_particle_settings *out);

/*
 Makes particles in a context, around a level of a sphere-mesh.

 time: in frames, where the level is (dm_spheres.time). desc: copied with its arrays. settings: NULL for the defaults; copied.
 out: receives the handle, which is the caller's to destroy. The particles keep what they need of context and level, which may be
 destroyed before them.

 Threads: any; other calls on the context wait meanwhile, and it waits for the device.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT naming the particle, sphere or setting that
 is not finite or out of range; DM_ERROR_MEMORY; DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 desc is NULL or valid, and each of its arrays is NULL or has as many rows as it says; settings and out are NULL or valid.
 */
dm_result dm_particles_create(struct dm_context context,
                              struct dm_level level,
                              double time,
                              const struct dm_particles_desc *desc,
                              const struct dm_particle_settings *settings,
                              struct dm_particles *out);

/*
 Destroys particles.

 Threads: any; a call that uses them on another thread completes first. Does not wait for the device: memory goes when the
 device is done with it.

 Returns DM_OK, or DM_ERROR_HANDLE where there are no such particles (any more).
 */
dm_result dm_particles_destroy(struct dm_particles particles);

/*
 Lets particles fly for some seconds, while the level goes straight to where it is at a time. They bounce off its spheres,
 capsules and thick triangles, as often as their settings allow; nothing tunnels through, however fast, and none is inside at the
 end. Submits to the context's queue and does not wait, unless two frames are on their way already; on the CPU it computes.

 time: in frames, where the level is at the end. seconds: above 0, up to 1000.

 Threads: any.

 Returns DM_OK; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for a time that is not finite, or seconds out of range; DM_ERROR_VULKAN;
 DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC. Where it is not DM_OK neither particles nor level have moved.
 */
dm_result dm_particles_advance(struct dm_particles particles,
                               double time,
                               float seconds);

/*
 Has the level at a time at once, for cuts: no particle is hit on the way. Those inside are pushed out at the end of the next
 frame.

 time: in frames.

 Threads: any. Returns DM_OK, DM_ERROR_HANDLE, DM_ERROR_ARGUMENT for a time that is not finite, DM_ERROR_DEVICE_LOST or
 DM_ERROR_PANIC.
 */
dm_result dm_particles_place(struct dm_particles particles,
                             double time);

/*
 Reads particles after the last frame; waits for it.

 flights: where to put them; the arrays are the caller's.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_SIZE where flights has another number of rows;
 DM_ERROR_VULKAN; DM_ERROR_MEMORY; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 flights is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
 */
dm_result dm_particles_read(struct dm_particles particles,
                            const struct dm_flights *flights);

/*
 Replaces all particles; waits for the last frame. They have not touched anything yet.

 desc: as many as there are; copied with its arrays.

 Threads: any.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_ARGUMENT for another number of particles, or naming
 one that is not finite or out of range; DM_ERROR_VULKAN, DM_ERROR_MEMORY or DM_ERROR_DEVICE_LOST, by which some may be replaced and
 others not until a call succeeds; DM_ERROR_PANIC.

 Pointers:
 desc is NULL or valid, and each of its arrays is NULL or has as many rows as it says.
 */
dm_result dm_particles_write(struct dm_particles particles,
                             const struct dm_particles_desc *desc);

/*
 Makes a buffer of the host's an output of particles: dm_particles_record writes one vertex a particle, its position and, where
 the description has normals, which are DM_NORMAL_F32 then, its velocity in their place.

 context: the particles', made by dm_context_adopt or of the same device. desc: copied; the buffer stays the host's; its
 instance_stride is of no meaning. out: receives the handle, which is the caller's to destroy before the buffer.

 Threads: any. Submits nothing.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_STRUCT_SIZE; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the particles are of another
 context; DM_ERROR_ARGUMENT where the vertices do not fit, for normals in bytes, for a queue family that the device has not, or on
 the CPU; DM_ERROR_MEMORY for a buffer longer than a shader can bind; DM_ERROR_VULKAN; DM_ERROR_DEVICE_LOST; DM_ERROR_PANIC.

 Pointers:
 desc and out are NULL or valid; the buffer is valid and as long as desc says until the output is destroyed.
 */
dm_result dm_particles_output(struct dm_context context,
                              struct dm_particles particles,
                              const struct dm_output_desc *desc,
                              struct dm_output *out);

/*
 Records a frame into a command buffer of the host's: what dm_particles_advance submits, and the writing of the output.
 Submits nothing, waits for nothing, allocates nothing.

 The command buffer (VkCommandBuffer) before and after: as in dm_frame_record. The host submits it to the context's queue, once,
 and frames in the order of their recording.

 frame_slot: below DM_FRAME_SLOTS; what was recorded with it before has to be done, since its level is overwritten. time, seconds:
 as in dm_particles_advance. output: of these particles, or zero for none.

 Threads: any that may record into the command buffer.

 Returns DM_OK; DM_ERROR_NULL; DM_ERROR_HANDLE; DM_ERROR_FOREIGN where the output is of something else; DM_ERROR_ARGUMENT for the
 slot, the time or the seconds, or on the CPU; DM_ERROR_DEVICE_LOST where another call has found it; DM_ERROR_PANIC. Where it is
 not DM_OK nothing is recorded, and the level has not moved.

 Pointers:
 The command buffer is NULL or in the state above; particles and output are not destroyed before it is done.
 */
dm_result dm_particles_record(struct dm_particles particles,
                              void *command_buffer,
                              uint32_t frame_slot,
                              double time,
                              float seconds,
                              struct dm_output output);

#ifdef __cplusplus
}  // extern "C"
#endif  /* __cplusplus */

#endif  /* DERMIS_H */
