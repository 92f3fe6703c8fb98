//! Lets every call fail, one after the other.

use ash::vk;
use dermis::capi::dm_result::*;

use crate::{
    scenario::{Character, Lost, Objects, Run, Way},
    state::{self, Fault},
};

type Calls = Vec<(&'static str, &'static [vk::Result])>;

const LOST: vk::Result = vk::Result::ERROR_DEVICE_LOST;

/// Calls whose failure may cost nothing that a program would miss: memory that the CPU writes is asked for again, of another
/// kind; a name for debuggers; a measured time; the moment at which memory is given back.
const HARMLESS: [&str; 5] = [
    "vkAllocateMemory",
    "vkGetQueryPoolResults",
    "vkMapMemory",
    "vkSetDebugUtilsObjectNameEXT",
    "vkGetSemaphoreCounterValue",
];

/// Calls that are made for the first deformer of a context or its first frame and may not be for another: pipelines with their
/// names, a block of memory and timestamps are kept.
const ONCE: [&str; 8] = [
    "vkAllocateMemory",
    "vkCreateComputePipelines",
    "vkCreateDescriptorSetLayout",
    "vkCreatePipelineLayout",
    "vkCreateQueryPool",
    "vkCreateShaderModule",
    "vkMapMemory",
    "vkSetDebugUtilsObjectNameEXT",
];

/// With what each call fails.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Codes {
    /// With everything that it may, one after the other.
    All,
    /// With one of what it may, in turn.
    InTurn,
}

/// Without a fault: the calls of each part, and all skins.
struct Whole {
    open: Calls,
    create: Calls,
    work: Calls,
    close: Calls,
    bits: Vec<Vec<u32>>,
}

/// What a reset that fails leaves.
pub(crate) fn broken_state(way: &dyn Way, character: &Character) {
    let (objects, run) = (Objects::new(way, character), Run::default());
    state::begin(None);
    assert!(objects.open(&run).is_ok() && objects.create(&run).is_ok());
    objects.break_state();
    objects.close();
}

/// Every call of making a context.
pub(crate) fn opening(way: &dyn Way, character: &Character) {
    let whole = whole(way, character);
    let sweep = Sweep {
        way,
        character,
        codes: Codes::All,
        whole,
    };
    eprintln!("opening: {} runs", sweep.open());
}

/// Every call.
pub(crate) fn every_call(way: &dyn Way, character: &Character, codes: Codes) {
    let sweep = Sweep {
        way,
        character,
        codes,
        whole: whole(way, character),
    };
    let runs = [
        sweep.open(),
        sweep.create(),
        sweep.work(),
        sweep.close(),
        sweep.loss(),
    ];
    // After all that, a device is as good as new.
    assert!(whole(way, character).bits == sweep.whole.bits);
    let Whole {
        open,
        create,
        work,
        close,
        ..
    } = &sweep.whole;
    let calls = [open, create, work, close].map(Vec::len);
    eprintln!("calls {calls:?} of opening, creating, working, closing; runs {runs:?}");
}

fn whole(way: &dyn Way, character: &Character) -> Whole {
    let (objects, run) = (Objects::new(way, character), Run::default());
    let part = |work: &dyn Fn() -> Result<(), Lost>| {
        state::begin(None);
        assert!(work().is_ok());
        state::calls()
    };
    let whole = Whole {
        open: part(&|| objects.open(&run)),
        create: part(&|| objects.create(&run)),
        work: part(&|| objects.work(&run)),
        close: part(&|| {
            objects.close();
            Ok(())
        }),
        bits: run.bits.take(),
    };
    assert_eq!(*run.failures.borrow(), vec![]);
    assert!(state::live().is_empty(), "{:?}", state::live());
    whole
}

/// A fault for each code with which each call may fail.
fn faults(calls: &Calls) -> impl Iterator<Item = Fault> {
    calls.iter().enumerate().flat_map(|(row, &(name, codes))| {
        let after = calls[..row].iter().filter(|c| c.0 == name).count();
        let fault = move |code: &vk::Result| Fault {
            name,
            after,
            code: *code,
        };
        codes.iter().map(fault)
    })
}

/// Lets a fault happen in calls of dermis: at most one fails, and says why.
fn strike(fault: Fault, work: impl FnOnce(&Run) -> Result<(), Lost>) -> (Run, Result<(), Lost>) {
    let run = Run::default();
    state::begin(Some(fault));
    let outcome = work(&run);
    assert!(state::struck(), "{fault:?} did not come");
    let failures = run.failures.take();
    match &failures[..] {
        [] => assert!(HARMLESS.contains(&fault.name), "{fault:?}"),
        [(result, message)] => {
            let wanted = match fault.code {
                LOST => DM_ERROR_DEVICE_LOST,
                _ => DM_ERROR_MEMORY,
            };
            assert_eq!(*result, wanted, "{fault:?}: {message}");
            assert!(message.contains(fault.name), "{fault:?}: {message}");
        }
        _ => panic!("{fault:?}: {failures:?}"),
    }
    (run, outcome)
}

struct Sweep<'a> {
    way: &'a dyn Way,
    character: &'a Character,
    codes: Codes,
    whole: Whole,
}

impl Sweep<'_> {
    fn objects(&self) -> Objects<'_> {
        Objects::new(self.way, self.character)
    }

    fn faults(&self, calls: &Calls) -> Vec<Fault> {
        let all: Vec<_> = faults(calls).collect();
        let of_one_call = |a: &Fault, b: &Fault| (a.name, a.after) == (b.name, b.after);
        let in_turn = |faults: &[Fault]| faults[faults[0].after % faults.len()];
        match self.codes {
            Codes::All => all,
            Codes::InTurn => all.chunk_by(of_one_call).map(in_turn).collect(),
        }
    }

    /// Faults that the device survives.
    fn memory_faults(&self, calls: &Calls) -> impl Iterator<Item = Fault> {
        let all = self.faults(calls).into_iter();
        all.filter(|fault| fault.code != LOST)
    }

    /// Faults that it does not.
    fn losses(&self, calls: &Calls) -> impl Iterator<Item = Fault> {
        let all = self.faults(calls).into_iter();
        all.filter(|fault| fault.code == LOST)
    }

    /// Opened, without a fault.
    fn opened(&self) -> Objects<'_> {
        let objects = self.objects();
        state::begin(None);
        assert!(objects.open(&Run::default()).is_ok());
        objects
    }

    /// The context is made again where it failed.
    fn open(&self) -> usize {
        let mut runs = 0;
        for fault in self.memory_faults(&self.whole.open) {
            let objects = self.objects();
            let (_, outcome) = strike(fault, |run| objects.open(run));
            assert!(outcome.is_ok());
            objects.close();
            assert!(state::live().is_empty(), "{fault:?}: {:?}", state::live());
            runs += 1;
        }
        runs
    }

    /// Deformers in one context, which fail, leave nothing, and are made in the end.
    fn create(&self) -> usize {
        let shared = self.opened();
        assert!(shared.create(&Run::default()).is_ok());
        shared.clear();
        let left = shared.settled();
        let mut runs = 0;
        for fault in self.memory_faults(&self.whole.create) {
            let own = ONCE.contains(&fault.name).then(|| self.opened());
            let objects = own.as_ref().unwrap_or(&shared);
            let (_, outcome) = strike(fault, |run| objects.try_create(run));
            assert!(outcome.is_ok());
            objects.clear();
            if let Some(own) = own {
                own.settled();
                own.close();
            }
            assert_eq!(shared.settled(), left, "{fault:?}");
            runs += 1;
        }
        let run = Run::default();
        assert!(shared.create(&run).is_ok() && shared.work(&run).is_ok());
        assert!(run.bits.take() == self.whole.bits);
        shared.close();
        assert!(state::live().is_empty(), "{:?}", state::live());
        runs
    }

    /// One deformer: whatever fails is done again, and the skin is the same.
    fn work(&self) -> usize {
        let objects = self.opened();
        assert!(objects.create(&Run::default()).is_ok());
        let mut runs = 0;
        for fault in self.memory_faults(&self.whole.work) {
            let own = ONCE.contains(&fault.name).then(|| self.opened());
            if let Some(own) = &own {
                assert!(own.create(&Run::default()).is_ok());
            }
            let used = own.as_ref().unwrap_or(&objects);
            let (run, outcome) = strike(fault, |run| used.work(run));
            assert!(outcome.is_ok());
            assert!(run.bits.take() == self.whole.bits, "{fault:?}");
            if let Some(own) = own {
                own.close();
            }
            runs += 1;
        }
        objects.close();
        assert!(state::live().is_empty(), "{:?}", state::live());
        runs
    }

    /// Destroying succeeds whatever fails in it; the codes take turns.
    fn close(&self) -> usize {
        let calls = &self.whole.close;
        for (row, &(name, codes)) in calls.iter().enumerate() {
            let objects = self.opened();
            let run = Run::default();
            assert!(objects.create(&run).is_ok() && objects.one_frame(&run).is_ok());
            let after = calls[..row].iter().filter(|c| c.0 == name).count();
            let code = codes[row % codes.len()];
            state::begin(Some(Fault { name, after, code }));
            objects.close();
            assert!(state::live().is_empty(), "{name}: {:?}", state::live());
        }
        calls.len()
    }

    /// The device is lost in every call that can tell so. All is refused from then on, and all can be destroyed.
    fn loss(&self) -> usize {
        let Whole {
            open, create, work, ..
        } = &self.whole;
        let mut runs = 0;
        for (part, calls) in [open, create, work].into_iter().enumerate() {
            for fault in self.losses(calls) {
                let (objects, run) = (self.objects(), Run::default());
                state::begin(None);
                let before = [Objects::open, Objects::create];
                for step in &before[..part] {
                    assert!(step(&objects, &run).is_ok());
                }
                _ = strike(fault, |run| match part {
                    0 => objects.open(run),
                    1 => objects.create(run),
                    _ => objects.work(run),
                });
                objects.all_refuse();
                // By the first call that finds it, where there is a log.
                assert_eq!(state::told(), u32::from(part > 0), "{fault:?}");
                objects.close();
                assert!(state::live().is_empty(), "{fault:?}: {:?}", state::live());
                runs += 1;
            }
        }
        runs
    }
}
