//! Files change under a running program.

use super::{LIBRARY, SHADER, dispatch, open, write};
use lightwell::gpu::{Gpu, ShaderEvent};
use std::time::{Duration, Instant};

const FIRST: [u32; 4] = [42, 84, 126, 168];

/// Polls like frames do, until something was taken up.
fn wait(gpu: &Gpu) -> Vec<ShaderEvent> {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(20) {
        let events = gpu.shaders.poll();
        if !events.is_empty() {
            return events;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("the change was not noticed");
}

/// Polls for as long as a change needs to arrive, and a good deal longer.
fn nothing_happens(gpu: &Gpu) {
    let start = Instant::now();
    while start.elapsed() < Duration::from_millis(600) {
        assert_eq!(gpu.shaders.poll(), []);
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn reloaded() -> Vec<ShaderEvent> {
    vec![ShaderEvent::Reloaded("test.wgsl".into())]
}

#[test]
fn a_good_edit_is_used() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    let revision = gpu.shaders.revision();
    write(dir.path(), "test.wgsl", &SHADER.replace("2u", "3u"));
    assert_eq!(wait(&gpu), reloaded());
    assert!(gpu.shaders.revision() > revision);
    assert_eq!(dispatch(&gpu).expect("pipeline"), [43, 86, 129, 172]);
}

#[test]
fn a_broken_edit_keeps_the_last_good_pipeline_until_it_is_mended() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    let revision = gpu.shaders.revision();
    write(dir.path(), "test.wgsl", &SHADER.replace("answer() +", "nonsense +"));
    assert!(matches!(&wait(&gpu)[..], [ShaderEvent::Broken(_)]));
    assert_eq!(dispatch(&gpu).expect("last good"), FIRST);
    assert_eq!(gpu.shaders.revision(), revision);
    let errors = gpu.shaders.errors();
    let [error] = &errors[..] else { panic!("{errors:?}") };
    assert_eq!((error.file.as_str(), error.line, error.column), ("test.wgsl", 9, 21), "{error}");
    // The excerpt shows the line at fault.
    assert!(error.to_string().contains("(nonsense + 2u)"), "{error}");

    write(dir.path(), "test.wgsl", &SHADER.replace("2u", "60u"));
    assert_eq!(wait(&gpu), reloaded());
    assert_eq!(gpu.shaders.errors(), []);
    assert_eq!(dispatch(&gpu).expect("pipeline"), [100, 200, 300, 400]);
}

#[test]
fn what_only_the_device_refuses_keeps_the_last_good_pipeline_too() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    write(dir.path(), "test.wgsl", &SHADER.replace("workgroup_size(4)", "workgroup_size(4, 4096, 4096)"));
    wait(&gpu);
    assert_eq!(dispatch(&gpu).expect("last good"), FIRST);
    assert!(gpu.shaders.errors()[0].to_string().contains("test.wgsl"), "{:?}", gpu.shaders.errors());
    write(dir.path(), "test.wgsl", SHADER);
    wait(&gpu);
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    assert_eq!(gpu.shaders.errors(), []);
}

#[test]
fn an_empty_file_is_passed_over() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    write(dir.path(), "test.wgsl", "");
    nothing_happens(&gpu);
    assert_eq!(gpu.shaders.errors(), []);
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
}

#[test]
fn reading_is_no_change() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    let revision = gpu.shaders.revision();
    std::fs::read(dir.path().join("test.wgsl")).expect("read");
    // Saved without a difference: not a change either.
    write(dir.path(), "test.wgsl", SHADER);
    nothing_happens(&gpu);
    assert_eq!(gpu.shaders.revision(), revision);
}

#[test]
fn a_save_by_renaming_is_noticed_each_time() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    for (number, first) in [(3, 43), (4, 44), (5, 45)] {
        write(dir.path(), ".test.wgsl.swp", &SHADER.replace("2u", &format!("{number}u")));
        std::fs::rename(dir.path().join(".test.wgsl.swp"), dir.path().join("test.wgsl")).expect("rename");
        assert_eq!(wait(&gpu), reloaded());
        assert_eq!(dispatch(&gpu).expect("pipeline")[0], first);
    }
}

#[test]
fn a_save_by_removing_and_writing_is_noticed() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    std::fs::remove_file(dir.path().join("test.wgsl")).expect("remove");
    nothing_happens(&gpu);
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    write(dir.path(), "test.wgsl", &SHADER.replace("2u", "3u"));
    assert_eq!(wait(&gpu), reloaded());
    assert_eq!(dispatch(&gpu).expect("pipeline")[0], 43);
}

#[test]
fn a_changed_import_reloads_what_imports_it() {
    let (dir, gpu) = open();
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    write(dir.path(), "lib/numbers.wgsl", &LIBRARY.replace("40u", "98u"));
    assert_eq!(wait(&gpu), reloaded());
    assert_eq!(dispatch(&gpu).expect("pipeline"), [100, 200, 300, 400]);

    write(dir.path(), "lib/numbers.wgsl", &LIBRARY.replace("40u", "40.5"));
    assert!(matches!(&wait(&gpu)[..], [ShaderEvent::Broken(_)]));
    let error = gpu.shaders.errors().remove(0);
    assert_eq!((error.file.as_str(), error.line), ("lib/numbers.wgsl", 4), "{error}");
    assert!(error.to_string().contains("test.wgsl"), "{error}");
    assert_eq!(dispatch(&gpu).expect("last good"), [100, 200, 300, 400]);
}

#[test]
fn a_shader_that_never_compiled_works_once_it_is_mended() {
    let (dir, gpu) = open();
    write(dir.path(), "lib/numbers.wgsl", "#define_import_path test::numbers\n\nfn other() {}\n");
    let gpu = super::open_dir(&{
        drop(gpu);
        dir.path().to_owned()
    });
    assert!(dispatch(&gpu).is_err());
    assert_eq!(gpu.shaders.errors().len(), 1);
    write(dir.path(), "lib/numbers.wgsl", LIBRARY);
    assert_eq!(wait(&gpu), reloaded());
    assert_eq!(dispatch(&gpu).expect("pipeline"), FIRST);
    assert_eq!(gpu.shaders.errors(), []);
}
