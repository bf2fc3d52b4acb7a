use crate::robot::config;
use nextview_scan::*;
#[test]
fn dbg() {
    let config = config();
    let cell = config.robot.as_ref().unwrap().cell().unwrap();
    let object = SimulatedObject::new(&config).unwrap();
    println!("{:?} {:?} {}", object.scene.room(), object.scene.planning_box(0.01), object.views.len());
    for v in 0..5.min(object.views.len()) {
        let p = object.views.pose(v);
        let s = cell.solutions(&p);
        println!("{v} {:?} {} solutions", p.translation(), s.len());
    }
    let source = Simulation::new(&object, &config, None);
    let mut run = ScanRun::begin(&source, &config, Begin::default()).unwrap();
    let r = run.next();
    println!("{:?}", r.is_ok());
}
